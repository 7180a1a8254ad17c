// SPDX-License-Identifier: MIT
#include "edvo/odometry/moving_object_guard.hpp"

#include <algorithm>

namespace edvo {
namespace {

constexpr double kSuspicious = 1.4;     // times the expected sigma
constexpr double kSudden = 0.01;        // [widths of the image] off the constant velocity
constexpr double kClearlyBetter = 0.8;  // times the sigma of another pose: prefer this one
constexpr double kInDoubt = 1.25;       // the same while a second motion is expected
constexpr double kTukey = 1.5;          // [sigmas] cut-off of the robust alignment
constexpr double kTwoMotions = 0.003;   // [widths of the image] between poses: not the same motion
constexpr int kExpected = 15;           // frames for which a second motion is expected

}  // namespace

// Something large that moves on its own is what coarse levels align to; soon after a keyframe its
// motion explains the image as well as the camera's does. Fine levels alone, from the constant
// velocity (or from no motion, if that is clearly better), with a loss that ignores outliers, find
// the camera's motion again. Once the two have differed, the robust one is preferred for a while.
AlignResult MovingObjectGuard::check(const AlignResult& first, const Reference& reference,
                                     const Frame& frame, const SE3& velocity,
                                     const PositionPrior& prior, TrackingState& state,
                                     AlignScratch& scratch) const {
  Alignment predicted = state.alignment;
  predicted.cur_from_ref = velocity * state.alignment.cur_from_ref;
  const int level = options_.finest_level;
  const bool sudden =
      mean_flow(reference, level, first.alignment.cur_from_ref, predicted.cur_from_ref) > kSudden;
  const double limit = (sudden ? 1.0 : kSuspicious) * expected_sigma(state);
  if (state.moving_object_frames == 0 && first.sigma < limit) return first;

  const AlignResult second =
      retrack_robust(reference, frame, predicted, state.alignment, prior, scratch);
  const bool differ = mean_flow(reference, level, first.alignment.cur_from_ref,
                                second.alignment.cur_from_ref) > kTwoMotions;
  const double preference =
      state.moving_object_frames > 0 ? kInDoubt : (differ ? 1.0 : kClearlyBetter);
  state.moving_object_frames = std::max(0, state.moving_object_frames - 1);
  const bool better = first.status == AlignStatus::kLost || second.sigma < preference * first.sigma;
  if (second.status == AlignStatus::kLost || !better) return first;
  if (differ) state.moving_object_frames = kExpected;
  return second;
}

AlignResult MovingObjectGuard::retrack_robust(const Reference& reference, const Frame& frame,
                                              const Alignment& predicted, const Alignment& last,
                                              const PositionPrior& prior,
                                              AlignScratch& scratch) const {
  AlignOptions options = options_;
  options.coarsest_level = std::min(options.coarsest_level, options.finest_level + 1);
  options.loss = Loss::kTukey;
  options.loss_parameter = kTukey;
  AlignResult best;
  for (const Alignment& guess : {predicted, last}) {
    const AlignResult other = align(reference, frame, guess, options, scratch, prior);
    if (other.status != AlignStatus::kTracked) continue;
    // An alignment that is still creeping may be anywhere on the way, unless it is expected there.
    if (!other.levels.back().converged &&
        mean_flow(reference, options.finest_level, other.alignment.cur_from_ref,
                  predicted.cur_from_ref) > kSudden)
      continue;
    if (best.status == AlignStatus::kLost || other.sigma < kClearlyBetter * best.sigma)
      best = other;
  }
  return best;
}

}  // namespace edvo
