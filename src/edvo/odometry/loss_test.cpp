// SPDX-License-Identifier: MIT
#include "edvo/odometry/loss_test.hpp"

#include "edvo/align/local_correlation.hpp"

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

// Residuals alone do not tell a wrong pose from a change of exposure or from the first motion after
// a long rest, nor does correlation tell it from noise; both together do. Of the 2159 frames of
// fr1/xyz, desk, rpy and ICL-NUIM kt3 sigma is at most 2.97 times the usual one, and the
// correlation at least 0.79; wrong poses after a gap of 0.4 s have 4 to 9 times and 0.5 to 0.87.
constexpr double kGrown = 2.5, kPoorCorrelation = 0.75;
constexpr double kFarGrown = 3.2, kFairCorrelation = 0.9;

// Where residuals are large, the parts of the images tell: docs/adr/0017. Of 14,779 frames of real
// and rendered sequences that are right, at 2 to 60 Hz, one has less than 0.34; wrong poses have
// 0.1 to 0.5. Where something hides much of the view, right ones have less, too, but the rest
// correlates.
constexpr double kLargeSigma = 16;                         // [grey levels]
constexpr double kPoorFit = 0.6;                           // there may be a better pose
constexpr double kNoFit = 0.3, kSomewhatAlike = 0.87;      // fit, and correlation of what fits
constexpr double kLittleFit = 0.5, kLittleAlike = 0.7;     // the same
constexpr double kMostFirstSigma = 20, kFirstAlike = 0.9;  // of a segment's first motion

// No camera in a hand or on an indoor robot moves faster.
constexpr double kMostSpeed = 8;            // [m/s]
constexpr double kMostTurn = 15;            // [rad/s]
constexpr double kLeastSeconds = 1.0 / 30;  // [s] stamps nearer to each other may be wrong

constexpr int kGrid = 8;             // [px]
constexpr int kOddGrid = 7;          // [px] sees rows of both parities, which may differ
constexpr double kHardlyAny = 0.01;  // [0..1] of the grid
constexpr double kFewOthers = 0.02;  // [0..1] of its depths
constexpr int kMostOthers = 100;     // of the grid: no need to look at all of it

// An image of the same place from elsewhere can be aligned well, and no camera moved there.
bool is_too_fast(const AlignResult& result, const TrackingState& state, const Stamp& stamp) {
  if (!state.stamp) return false;
  const double seconds = std::max(kLeastSeconds, seconds_between(*state.stamp, stamp));
  const SE3 moved = result.alignment.cur_from_ref * inverse(state.alignment.cur_from_ref);
  return moved.translation.norm() > kMostSpeed * seconds ||
         rotation_angle(moved) > kMostTurn * seconds;
}

}  // namespace

LossCause loss_cause(const AlignResult& result, const AlignOptions& options,
                     const TrackingState& state, const Stamp& stamp) {
  if (result.overlap < options.min_overlap) return LossCause::kOverlap;
  if (result.inlier_ratio < options.min_inliers) return LossCause::kOutliers;
  if (!(result.correlation >= options.min_correlation)) return LossCause::kUnlike;
  if (result.status == AlignStatus::kLost) return LossCause::kUnlike;  // not finite
  const double growth = state.usual_sigma > 0 ? result.sigma / sigma_baseline(state) : 0;
  if ((growth > kGrown && result.correlation < kPoorCorrelation) ||
      (growth > kFarGrown && result.correlation < kFairCorrelation))
    return LossCause::kResiduals;
  if (is_too_fast(result, state, stamp)) return LossCause::kTooFast;
  return LossCause::kNone;
}

double local_fit(const AlignResult& result, const Reference& reference, const Frame& frame,
                 const AlignOptions& options, AlignScratch& scratch) {
  if (result.status == AlignStatus::kLost || result.sigma < kLargeSigma) return 1;
  return local_correlation(reference, frame, options.finest_level, result.alignment, scratch);
}

bool fits_poorly(double fit) {
  return fit < kPoorFit;
}

bool is_unlike(const AlignResult& result, double fit, const TrackingState& state) {
  const double alike = result.correlation;
  const bool is_first = state.usual_sigma == 0;
  return (fit < kNoFit && alike < kSomewhatAlike) || (fit < kLittleFit && alike < kLittleAlike) ||
         (is_first && result.sigma > kMostFirstSigma && alike < kFirstAlike);
}

bool has_constant_depth(const Frame& frame, const SelectOptions& options) {
  float first = 0;
  int valid = 0, others = 0;
  for (int y = kOddGrid / 2; y < frame.depth.rows(); y += kOddGrid)
    for (int x = kOddGrid / 2; x < frame.depth.cols(); x += kOddGrid) {
      const float z = frame.depth(y, x);
      if (!(static_cast<double>(z) >= options.min_depth &&
            static_cast<double>(z) <= options.max_depth))
        continue;
      if (valid++ == 0) first = z;
      others += z != first ? 1 : 0;
      if (others > kMostOthers) return false;
    }
  return valid > 0 && others < kFewOthers * valid;
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
