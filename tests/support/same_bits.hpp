// SPDX-License-Identifier: MIT
// Comparing images to the last bit.
#pragma once

#include <cstring>
#include <opencv2/core.hpp>

namespace edvo::test {

// NaN equals the same NaN.
[[nodiscard]] inline bool same_bits(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int y = 0; y < a.rows; ++y)
    if (std::memcmp(a.ptr(y), b.ptr(y), a.elemSize() * a.cols) != 0) return false;
  return true;
}

}  // namespace edvo::test
