// SPDX-License-Identifier: MIT
#include "edvo/features/edge_depth.hpp"

#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

constexpr int kSide = 2 * kEdgeDepthRadius + 1;
constexpr float kFarthest = 1.04F;          // depth / the nearest one of the same surface
constexpr std::int32_t kLeastSupport = 12;  // pixels of the window, about a quarter
constexpr float kInfinity = std::numeric_limits<float>::infinity();

static_assert(kSide + 1 == simd::kWidth);

// corner: the window's first pixel. The last number of each row is not part of the window.
// Returns the nearest depth that has support, or infinity.
EDVO_CLONES float nearest_supported(const float* corner, std::size_t stride) {
  const Int8 inside = {-1, -1, -1, -1, -1, -1, -1, 0};
  const Float8 infinite = Float8{} + kInfinity;
  Float8 rows[kSide];
  Float8 nearest = infinite, farthest{};
  for (std::size_t j = 0; j < kSide; ++j) {
    const Float8 z = simd::Load(corner + j * stride).value;
    rows[j] = (inside & (z > 0.F)) ? z : infinite;
    nearest = rows[j] < nearest ? rows[j] : nearest;
    const Float8 finite = rows[j] < kInfinity ? rows[j] : Float8{};
    farthest = finite > farthest ? finite : farthest;
  }
  float low = kInfinity, high = 0;
  for (std::size_t k = 0; k < simd::kWidth; ++k) {
    low = std::min(low, nearest[k]);
    high = std::max(high, farthest[k]);
  }
  if (high <= kFarthest * low) return low;
  while (low < kInfinity) {
    Int8 members{};  // each counts as -1
    Float8 next = infinite;
    for (const Float8& z : rows) {
      const Int8 behind = z > low;
      members += ~(z < low) & (z <= kFarthest * low);
      next = (behind & (z < next)) ? z : next;
    }
    std::int32_t support = 0;
    for (std::size_t k = 0; k < simd::kWidth; ++k) support -= members[k];
    if (support >= kLeastSupport) return low;
    low = kInfinity;
    for (std::size_t k = 0; k < simd::kWidth; ++k) low = std::min(low, next[k]);
  }
  return kInfinity;
}

}  // namespace

float edge_depth(const cv::Mat_<float>& depth, cv::Point pixel) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  assert(cv::Rect(kSide / 2 + 1, kSide / 2 + 1, depth.cols - kSide - 1, depth.rows - kSide - 1)
             .contains(pixel));
  const float own = depth(pixel);
  if (!(own > 0.F)) return kNone;
  const float* corner = depth[pixel.y - kEdgeDepthRadius] + pixel.x - kEdgeDepthRadius;
  const float low = nearest_supported(corner, depth.step1());
  const auto is_member = [&](float z) { return z >= low && z <= kFarthest * low; };
  if (is_member(own)) return own;
  float sum = 0;
  int members = 0;
  for (const cv::Point& step : {cv::Point(-1, 0), {1, 0}, {0, -1}, {0, 1}})
    if (const float z = depth(pixel + step); is_member(z)) {
      sum += z;
      ++members;
    }
  return members > 0 ? sum / static_cast<float>(members) : kNone;
}

}  // namespace edvo
