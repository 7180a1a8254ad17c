# edvo_add_library(NAME FOLDERS folder... [HEADERS header...] [PUBLIC lib...] [PRIVATE lib...]):
# the part edvo::NAME of the library, from the .cpp files of src/edvo/<folder>; a new file is picked
# up at the next configure. HEADERS are those that a user may include; they are installed together
# with what they include. Parts without HEADERS are not installed.
function(edvo_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 part "" "" "FOLDERS;HEADERS;SOURCES;PUBLIC;PRIVATE")
  list(TRANSFORM part_FOLDERS REPLACE "(.+)" "${CMAKE_CURRENT_SOURCE_DIR}/edvo/\\1/*.cpp"
       OUTPUT_VARIABLE patterns)
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  set(target edvo_${name})
  set(kind "")  # static or shared, as BUILD_SHARED_LIBS says
  if(NOT part_HEADERS)
    set(kind STATIC)
  endif()
  add_library(${target} ${kind} ${sources} ${part_SOURCES})
  add_library(edvo::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} SOVERSION ${PROJECT_VERSION}
                        DEFINE_SYMBOL "")  # static and shared objects compile alike
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}>
                                              $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} PUBLIC ${part_PUBLIC} PRIVATE ${part_PRIVATE})
  # Contracting a*b+c differs between optimisation levels; results must not.
  # No one reads errno or traps: loops with sqrt and choices can be vectorized, with the same bits.
  target_compile_options(${target} PRIVATE -ffp-contract=off -fno-math-errno -fno-trapping-math)
  edvo_set_warnings(${target})
  if(part_HEADERS)
    edvo_install_part(${name} ${part_HEADERS})
  endif()
endfunction()

# The headers of src that are named, and all that they include, relative to src.
function(edvo_with_included_headers out)
  set(found "")
  set(next ${ARGN})
  while(next)
    list(POP_FRONT next header)
    if(header IN_LIST found)
      continue()
    endif()
    list(APPEND found ${header})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
                 ${CMAKE_CURRENT_SOURCE_DIR}/${header})
    file(STRINGS ${header} includes REGEX "^#include \"edvo/")
    foreach(line IN LISTS includes)
      string(REGEX REPLACE "^#include \"(edvo/[^\"]+)\".*" "\\1" included "${line}")
      list(APPEND next ${included})
    endforeach()
  endwhile()
  set(${out} ${found} PARENT_SCOPE)
endfunction()

# Library, headers and CMake targets of one part, so that find_package finds it alone.
function(edvo_install_part name)
  edvo_with_included_headers(headers ${ARGN})
  set_property(GLOBAL APPEND PROPERTY edvo_public_headers ${ARGN})
  foreach(header IN LISTS headers)
    cmake_path(GET header PARENT_PATH folder)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
  endforeach()
  install(TARGETS edvo_${name} EXPORT edvo_${name})
  install(EXPORT edvo_${name} NAMESPACE edvo:: FILE edvo_${name}.cmake
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/edvo)
endfunction()
