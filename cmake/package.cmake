# cpack -G DEB (scripts/deb.sh): two packages, edvo with the program and libedvo-dev with what
# find_package(edvo) reads. A package belongs to the release that it was built on, as its libraries'
# names do.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The edvo authors")
set(CPACK_PACKAGE_CONTACT "The edvo authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_DEB_COMPONENT_INSTALL ON)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
cmake_host_system_information(RESULT distribution QUERY DISTRIB_INFO)
if(distribution_ID STREQUAL "debian")
  set(CPACK_DEBIAN_PACKAGE_RELEASE "1~deb${distribution_VERSION_ID}")
endif()
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME edvo)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "The program edvo: tracks a recording, evaluates trajectories, renders sequences.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libedvo-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "Headers, libraries and CMake files of edvo, for find_package(edvo).")
# What scripts/packages.txt has for the library.
string(JOIN ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS libeigen3-dev libopencv-core-dev
       libopencv-imgproc-dev libopencv-dnn-dev libdnnl-dev libfmt-dev nlohmann-json3-dev
       libyaml-cpp-dev libarchive-dev libspng-dev libdeflate-dev libturbojpeg0-dev pkgconf)
if(BUILD_SHARED_LIBS)
  set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS libedvo-dev)
endif()
include(CPack)
