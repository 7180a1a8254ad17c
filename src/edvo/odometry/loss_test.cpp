// SPDX-License-Identifier: MIT
#include "edvo/odometry/loss_test.hpp"

#include <cmath>

namespace edvo {
namespace {

constexpr int kGrid = 8;             // [px]
constexpr double kHardlyAny = 0.01;  // [0..1] of the grid

}  // namespace

LossCause loss_cause(const AlignResult& result, const AlignOptions& options, const TrackingState&) {
  if (result.overlap < options.min_overlap) return LossCause::kOverlap;
  if (result.inlier_ratio < options.min_inliers) return LossCause::kOutliers;
  if (!(result.correlation >= options.min_correlation)) return LossCause::kUnlike;
  if (result.status == AlignStatus::kLost) return LossCause::kUnlike;  // not finite
  return LossCause::kNone;
}

LossCause image_fault(const Frame& frame, const SelectOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  int all = 0, deep = 0, textured = 0, both = 0;
  for (int y = kGrid / 2; y + 1 < gray.rows; y += kGrid)
    for (int x = kGrid / 2; x + 1 < gray.cols; x += kGrid) {
      const auto z = static_cast<double>(frame.depth(y, x));
      const bool has_depth = z >= options.min_depth && z <= options.max_depth;
      const double gradient =
          0.5 * std::hypot(gray(y, x + 1) - gray(y, x - 1), gray(y + 1, x) - gray(y - 1, x));
      const bool has_texture = gradient >= options.min_gradient;
      ++all;
      deep += has_depth ? 1 : 0;
      textured += has_texture ? 1 : 0;
      both += has_depth && has_texture ? 1 : 0;
    }
  if (deep < kHardlyAny * all) return LossCause::kNoDepth;
  if (textured < kHardlyAny * all) return LossCause::kNoTexture;
  if (both < kHardlyAny * all) return LossCause::kFewPoints;
  return LossCause::kNone;
}

}  // namespace edvo
