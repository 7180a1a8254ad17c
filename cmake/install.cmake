# cmake --install: what src/CMakeLists.txt says of each part of the library, the program, and what
# find_package(edvo) reads.
include(CMakePackageConfigHelpers)
set(edvo_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/edvo)

if(TARGET edvo_app)
  install(TARGETS edvo_app COMPONENT program)
  install(FILES ${edvo_manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
  install(FILES ${edvo_completion} RENAME edvo COMPONENT program
          DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
endif()

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/edvoConfig.cmake.in
                              ${CMAKE_CURRENT_BINARY_DIR}/edvoConfig.cmake
                              INSTALL_DESTINATION ${edvo_cmake_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/edvoConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/edvoConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/edvoConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindOneDnn.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindOpenCVParts.cmake
              ${PROJECT_SOURCE_DIR}/cmake/read_version.cmake
        DESTINATION ${edvo_cmake_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/CHANGELOG.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
