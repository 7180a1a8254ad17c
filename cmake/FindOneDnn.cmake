# oneDNN 2 as the target OneDnn::OneDnn, with the OpenMP library by whose threads Debian's works.
#
# oneDNN's own CMake files ask for OpenCL, which Debian only recommends and edvo does not use.
find_path(OneDnn_INCLUDE_DIR oneapi/dnnl/dnnl_version.h)
find_library(OneDnn_LIBRARY dnnl)
mark_as_advanced(OneDnn_INCLUDE_DIR OneDnn_LIBRARY)

include(${CMAKE_CURRENT_LIST_DIR}/read_version.cmake)
edvo_read_version(OneDnn_VERSION ${OneDnn_INCLUDE_DIR}/oneapi/dnnl/dnnl_version.h
                  "MAJOR|MINOR|PATCH")

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OneDnn REQUIRED_VARS OneDnn_INCLUDE_DIR OneDnn_LIBRARY
                                  VERSION_VAR OneDnn_VERSION)

if(OneDnn_FOUND AND NOT TARGET OneDnn::OneDnn)
  add_library(OneDnn::OneDnn UNKNOWN IMPORTED)
  set_target_properties(OneDnn::OneDnn PROPERTIES
    IMPORTED_LOCATION ${OneDnn_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OneDnn_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES gomp)
endif()
