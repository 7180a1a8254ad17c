// SPDX-License-Identifier: MIT
// Reading an image between its pixels.
#pragma once

#include <opencv2/core.hpp>

namespace edvo {

// Whether (u, v) and a margin around it [px] can be read bilinearly. False for NaN.
[[nodiscard]] inline bool inside(const cv::Mat_<std::uint8_t>& image, float u, float v,
                                 int margin) {
  const float low = static_cast<float>(margin);
  return u >= low && v >= low && u < static_cast<float>(image.cols - 1 - margin) &&
         v < static_cast<float>(image.rows - 1 - margin);
}

// Intensity at (u, v) [px]; the caller has checked that it is inside.
[[nodiscard]] inline float bilinear(const cv::Mat_<std::uint8_t>& image, float u, float v) {
  const int x = static_cast<int>(u);
  const int y = static_cast<int>(v);
  const float a = u - static_cast<float>(x);
  const float b = v - static_cast<float>(y);
  const std::uint8_t* top = image[y] + x;
  const std::uint8_t* bottom = image[y + 1] + x;
  const float upper = static_cast<float>(top[0]) + a * static_cast<float>(top[1] - top[0]);
  const float lower = static_cast<float>(bottom[0]) + a * static_cast<float>(bottom[1] - bottom[0]);
  return upper + b * (lower - upper);
}

}  // namespace edvo
