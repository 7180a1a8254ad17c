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
EDVO_CLONES bool nearest_supported_has(const float* corner, std::size_t stride, float own) {
  const Int8 inside = {-1, -1, -1, -1, -1, -1, -1, 0};
  const Float8 infinite = Float8{} + kInfinity;
  Float8 rows[kSide];
  Float8 nearest = infinite, farthest{};
  for (std::size_t j = 0; j < kSide; ++j) {
    const Float8& z = simd::load(corner + j * stride);
    rows[j] = inside & (z > 0.F) ? z : infinite;
    nearest = rows[j] < nearest ? rows[j] : nearest;
    const Float8 finite = rows[j] < kInfinity ? rows[j] : Float8{};
    farthest = finite > farthest ? finite : farthest;
  }
  float low = kInfinity, high = 0;
  for (std::size_t k = 0; k < simd::kWidth; ++k) {
    low = std::min(low, nearest[k]);
    high = std::max(high, farthest[k]);
  }
  if (high <= kFarthest * low) return true;
  while (low <= own) {
    Int8 members{};  // each counts as -1
    Float8 next = infinite;
    for (const Float8& z : rows) {
      const Int8 behind = z > low;
      members += ~(z < low) & (z <= kFarthest * low);
      next = behind & (z < next) ? z : next;
    }
    std::int32_t support = 0;
    for (std::size_t k = 0; k < simd::kWidth; ++k) support -= members[k];
    if (support >= kLeastSupport) return own <= kFarthest * low;
    low = kInfinity;
    for (std::size_t k = 0; k < simd::kWidth; ++k) low = std::min(low, next[k]);
  }
  return false;
}

}  // namespace

bool on_nearest_surface(const cv::Mat_<float>& depth, cv::Point pixel) {
  assert(cv::Rect(kSide / 2 + 1, kSide / 2 + 1, depth.cols - kSide - 1, depth.rows - kSide - 1)
             .contains(pixel));
  const float own = depth(pixel);
  if (!(own > 0.F)) return false;
  const float* corner = depth[pixel.y - kEdgeDepthRadius] + pixel.x - kEdgeDepthRadius;
  return nearest_supported_has(corner, depth.step1(), own);
}

}  // namespace edvo
