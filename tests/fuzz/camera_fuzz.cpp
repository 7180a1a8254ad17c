// SPDX-License-Identifier: MIT
// Camera files of every kind; a camera that is taken is one, and its TOML gives it back.
#include "edvo/core/error.hpp"
#include "edvo/io/camera_file.hpp"
#include "fuzz/memory_file.hpp"

#include <cmath>

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::MemoryFile file;
  for (const cv::Size image : {cv::Size(), cv::Size(640, 480)}) {
    file.write(fuzz::text_of(data, size));
    DistortedCamera camera;
    try {
      camera = read_camera(file.path(), image);
    } catch (const Error&) {
      continue;
    }
    const Camera& pinhole = camera.pinhole;
    fuzz::require(pinhole.width > 0 && pinhole.height > 0 && std::isnormal(pinhole.fx) &&
                  std::isnormal(pinhole.fy));
    file.write(camera_to_toml(camera));
    const DistortedCamera again = read_camera(file.path(), {});
    fuzz::require(again.pinhole.fx == pinhole.fx && again.pinhole.cy == pinhole.cy &&
                  again.distortion == camera.distortion);
  }
  return 0;
}
