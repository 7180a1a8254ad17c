# Everything comes from Debian's packages; scripts/packages.txt names them. What a program that links
# edvo needs is said again in edvoConfig.cmake.in: keep both in step.
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(OpenCVParts 4.5 REQUIRED COMPONENTS core imgproc)
find_package(fmt REQUIRED)
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(tomlplusplus REQUIRED tomlplusplus)  # only its headers
if(EDVO_ODOMETRY_ONLY)
  return()
endif()

find_package(OpenCVParts 4.5 REQUIRED COMPONENTS dnn)
find_package(OneDnn 2.6 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(LibArchive REQUIRED)
pkg_check_modules(spng REQUIRED IMPORTED_TARGET spng)
pkg_check_modules(deflate REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(turbojpeg REQUIRED IMPORTED_TARGET libturbojpeg)
