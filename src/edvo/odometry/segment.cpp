// SPDX-License-Identifier: MIT
#include "edvo/odometry/segment.hpp"

#include "edvo/odometry/loss_test.hpp"

#include <algorithm>
#include <utility>

namespace edvo {
namespace {

constexpr double kUsualShare = 0.1;  // of a new frame in the usual sigma

using Guesses = InplaceVector<Alignment, kMostCandidates>;

// Of the frame to the reference keyframe, the one that costs least first.
Guesses guesses(const Segment& segment, const Frame& frame, const MotionCandidates& motions,
                const Config& config, AlignScratch& scratch) {
  Guesses all;
  InplaceVector<std::pair<double, std::size_t>, kMostCandidates> costs;  // and whose
  for (const SE3& motion : motions) {
    Alignment guess = segment.state.alignment;
    guess.cur_from_ref = motion * guess.cur_from_ref;
    costs.push_back(
        {coarse_cost(segment.reference, frame, guess, config.tracking, scratch), all.size()});
    all.push_back(guess);
  }
  std::sort(costs.begin(), costs.end());
  Guesses sorted;
  for (const auto& [cost, i] : costs) sorted.push_back(all[i]);
  return sorted;
}

// From anywhere that leaves a view in common: the alignment of the smallest residuals.
AlignResult align_from_afar(const Segment& segment, const Frame& frame, const SE3& velocity,
                            const Config& config, AlignScratch& scratch) {
  const MotionCandidates far = segment.predictor.far_candidates(frame, velocity, config, scratch);
  AlignResult best;
  for (const Alignment& guess : guesses(segment, frame, far, config, scratch)) {
    const AlignResult result =
        align(segment.reference, frame, guess, config.tracking, scratch, PositionPrior{});
    if (result.status == AlignStatus::kLost) continue;
    if (best.status == AlignStatus::kLost || result.sigma < best.sigma) best = result;
  }
  return best;
}

}  // namespace

SegmentAlignment align_in(Segment& segment, const Frame& frame, const Config& config,
                          const MovingObjectGuard& guard, AlignScratch& scratch) {
  TrackingState state = segment.state;
  const SE3 velocity = constant_velocity(state, frame.stamp);
  const PositionPrior prior = position_prior(state, frame.stamp, config.motion.acceleration);
  AlignResult result;
  const MotionCandidates near = segment.predictor.candidates(frame, velocity, config, scratch);
  for (const Alignment& guess : guesses(segment, frame, near, config, scratch)) {
    result = align(segment.reference, frame, guess, config.tracking, scratch, prior);
    if (result.status == AlignStatus::kTracked) break;
  }
  result = guard.check(result, segment.reference, frame, velocity, prior, state, scratch);
  LossCause loss = loss_cause(result, config.tracking, state, frame.stamp);
  const LossCause fault = loss == LossCause::kNone ? loss : image_fault(frame, config.selection);
  if (fault != LossCause::kNone) {
    loss = fault;
  } else if (loss != LossCause::kNone) {
    const AlignResult far = align_from_afar(segment, frame, velocity, config, scratch);
    const LossCause far_loss = loss_cause(far, config.tracking, state, frame.stamp);
    if (far_loss == LossCause::kNone) {
      result = far;
      loss = far_loss;
    }
  }
  return {.result = result, .loss = loss, .moving_object_frames = state.moving_object_frames};
}

void accept(Segment& segment, const Frame& frame, const SegmentAlignment& alignment) {
  TrackingState& state = segment.state;
  const AlignResult& result = alignment.result;
  state.last_from_current = state.alignment.cur_from_ref * inverse(result.alignment.cur_from_ref);
  state.motion_seconds = seconds_between(*state.stamp, frame.stamp);
  state.stamp = frame.stamp;
  state.alignment = result.alignment;
  state.moving_object_frames = alignment.moving_object_frames;
  state.usual_sigma +=
      (state.usual_sigma > 0 ? kUsualShare : 1.0) * (result.sigma - state.usual_sigma);
  ++state.frames_since_keyframe;
  ++segment.tracked;
}

}  // namespace edvo
