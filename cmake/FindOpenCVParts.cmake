# Single modules of OpenCV 4 as targets OpenCVParts::core, OpenCVParts::imgproc, ...
#
# Debian keeps OpenCV's own CMake files in libopencv-dev, which brings 400 packages (GDAL, VTK, ...)
# that edvo does not use. The small packages (libopencv-core-dev, ...) have headers and libraries
# only; this module finds those, below any CMAKE_PREFIX_PATH too.
find_path(OpenCVParts_INCLUDE_DIR opencv2/core/version.hpp PATH_SUFFIXES opencv4)
mark_as_advanced(OpenCVParts_INCLUDE_DIR)

include(${CMAKE_CURRENT_LIST_DIR}/read_version.cmake)
edvo_read_version(OpenCVParts_VERSION ${OpenCVParts_INCLUDE_DIR}/opencv2/core/version.hpp
                  "MAJOR|MINOR|REVISION")

set(libraries "")
foreach(part IN LISTS OpenCVParts_FIND_COMPONENTS)
  find_library(OpenCVParts_${part}_LIBRARY opencv_${part})
  mark_as_advanced(OpenCVParts_${part}_LIBRARY)
  list(APPEND libraries OpenCVParts_${part}_LIBRARY)
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVParts
  REQUIRED_VARS OpenCVParts_INCLUDE_DIR ${libraries}
  VERSION_VAR OpenCVParts_VERSION)

if(OpenCVParts_FOUND)
  foreach(part IN LISTS OpenCVParts_FIND_COMPONENTS)
    if(NOT TARGET OpenCVParts::${part})
      add_library(OpenCVParts::${part} UNKNOWN IMPORTED)
      set_target_properties(OpenCVParts::${part} PROPERTIES
        IMPORTED_LOCATION ${OpenCVParts_${part}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenCVParts_INCLUDE_DIR})
    endif()
  endforeach()
endif()
