// SPDX-License-Identifier: MIT
// Reading an image between its pixels.
#pragma once

#include "edvo/simd/float8.hpp"

#include <cstdint>
#include <cstring>
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

// An image at eight places.
struct Samples {
  simd::Float8 value, gx, gy;  // [grey levels], [grey levels / px]
};

// Byte k of each number.
template <int k>
[[gnu::always_inline]] inline void byte_of(const simd::Int8& word, simd::Float8& out) {
  out = simd::ToFloat8((word >> (8 * k)) & 255).value;
}

// Bilinear, the gradient by central differences of the same interpolant. (u, v): inside by a
// margin of 1. Four neighbours in a row are read at once, the left one in the low byte.
[[gnu::always_inline]] inline void sample(const cv::Mat_<std::uint8_t>& gray, const simd::Float8& u,
                                          const simd::Float8& v, Samples& out) {
  const simd::Int8 column = simd::ToInt8(u).value;
  const simd::Int8 row = simd::ToInt8(v).value;
  const simd::Float8 a = u - simd::ToFloat8(column).value;
  const simd::Float8 b = v - simd::ToFloat8(row).value;
  const auto stride = static_cast<std::int32_t>(gray.step[0]);
  const simd::Int8 offset = (row - 1) * stride + column - 1;
  const std::uint8_t* pixels = gray.data;
  simd::Int8 rows[4];
  for (int r = 0; r < 4; ++r) {
    simd::Int8 words{};
    for (std::size_t k = 0; k < simd::kWidth; ++k) {
      std::int32_t word = 0;
      std::memcpy(&word, pixels + offset[k] + r * stride, sizeof word);
      words[k] = word;
    }
    rows[r] = words;
  }
  simd::Float8 at[4], left[2], right[2];  // interpolated along the rows at u, u - 1 and u + 1
  for (int r = 0; r < 4; ++r) {
    simd::Float8 p0, p1, p2, p3;
    byte_of<1>(rows[r], p1);
    byte_of<2>(rows[r], p2);
    at[r] = p1 + a * (p2 - p1);
    if (r != 1 && r != 2) continue;
    byte_of<0>(rows[r], p0);
    byte_of<3>(rows[r], p3);
    left[r - 1] = p0 + a * (p1 - p0);
    right[r - 1] = p2 + a * (p3 - p2);
  }
  out.value = at[1] + b * (at[2] - at[1]);
  const simd::Float8 upper = right[0] - left[0], lower = right[1] - left[1];
  out.gx = 0.5F * (upper + b * (lower - upper));
  const simd::Float8 first = at[2] - at[0], second = at[3] - at[1];
  out.gy = 0.5F * (first + b * (second - first));
}

}  // namespace edvo
