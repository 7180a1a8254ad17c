// SPDX-License-Identifier: MIT
// Images as ROS messages carry them, without ROS.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/rgbd_image.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace edvo::ros {

// sensor_msgs/Image.
struct ImageMessage {
  std::int64_t stamp_ns = 0;
  std::string encoding;
  int width = 0, height = 0;  // [px]
  int step = 0;               // of a row [bytes]
  bool is_bigendian = false;
  std::vector<std::uint8_t> data;
};

// rgb8, bgr8, rgba8, bgra8 and mono8. Throws Error(kInput) naming the encoding or the sizes.
[[nodiscard]] cv::Mat_<cv::Vec3b> to_bgr(const ImageMessage& image);

// 32FC1 is metres, 16UC1 and mono16 are units (REP 118: millimetres). NaN = none. Throws
// Error(kInput).
[[nodiscard]] cv::Mat_<float> to_metres(const ImageMessage& image, double units_per_metre);

// sensor_msgs/CameraInfo: K row by row, D of plumb_bob, rational_polynomial or equidistant. Throws
// Error(kCalibration).
[[nodiscard]] DistortedCamera to_camera(int width, int height, std::span<const double, 9> k,
                                        const std::string& distortion_model,
                                        std::span<const double> d);

}  // namespace edvo::ros
