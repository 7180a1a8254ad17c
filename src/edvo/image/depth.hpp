// SPDX-License-Identifier: MIT
// Depth of the undistorted image, looked up where it is asked for: of most frames few pixels are.
#pragma once

#include "edvo/image/undistortion.hpp"

#include <cstdint>
#include <limits>
#include <vector>

namespace edvo {

class Depth {
 public:
  Depth() = default;
  // Already undistorted: H x W, [m], NaN = none.
  Depth(const cv::Mat_<float>& undistorted)  // NOLINT(google-explicit-constructor): is a Depth
      : values_(undistorted.isContinuous() ? undistorted : undistorted.clone()) {}
  // As the sensor has it. Both matrices are shared, not copied.
  Depth(const Undistortion& undistortion, const cv::Mat_<float>& sensor) : Depth(sensor) {
    sources_ = undistortion.nearest;
  }

  [[nodiscard]] int rows() const { return values_.rows; }
  [[nodiscard]] int cols() const { return values_.cols; }
  [[nodiscard]] cv::Size size() const { return values_.size(); }

  // [m], NaN = none.
  [[nodiscard]] float operator()(int y, int x) const {
    if (sources_.empty()) return values_(y, x);
    const std::int32_t source = sources_(y, x);
    return source < 0 ? std::numeric_limits<float>::quiet_NaN() : values_[0][source];
  }

  // Of the pixels with these row-major indices, NaN where they are negative. The indices become
  // those of the sensor's pixels.
  void look_up(std::vector<std::int32_t>& pixels, std::vector<float>& depths) const;

  // All of it as the sensor has it: H x W, [m], NaN = none. Not to be written to.
  [[nodiscard]] const cv::Mat_<float>& sensor() const { return values_; }

  // All of it, for who reads most pixels: H x W, [m], NaN = none.
  [[nodiscard]] cv::Mat_<float> undistorted() const;

 private:
  cv::Mat_<float> values_;
  cv::Mat_<std::int32_t> sources_;
};

}  // namespace edvo
