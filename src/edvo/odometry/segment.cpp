// SPDX-License-Identifier: MIT
#include "edvo/odometry/segment.hpp"

#include "edvo/align/local_correlation.hpp"
#include "edvo/odometry/loss_test.hpp"
#include "edvo/odometry/readout_time.hpp"
#include "edvo/odometry/resting_camera.hpp"

#include <algorithm>
#include <utility>

namespace edvo {
namespace {

constexpr double kUsualShare = 0.1;      // weight of a new frame in the running mean of sigma
constexpr double kLowGrowth = 1.02;      // of the low sigma, per frame
constexpr double kWellExplained = 0.85;  // [0..1] of the image, see motion_judge.cpp
constexpr int kDoubtful = 15;            // frames after a second motion

constexpr double kBetterFit = 0.05;  // of another alignment: prefer this one
constexpr int kNearLevels = 3;       // that a guess by corners is aligned at

using Guesses = InplaceVector<Alignment, kMostCandidates>;

// Where to start aligning to the reference keyframe: the last good alignment moved by each motion,
// the one of the least cost first.
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

// Of a rolling shutter's image: the last level is aligned with the velocity that the others tell.
AlignResult align_by_rows(const Segment& segment, Frame& frame, const Alignment& guess,
                          const AlignOptions& options, AlignScratch& scratch,
                          const PositionPrior& prior) {
  if (frame.shutter.readout_seconds == 0 || options.finest_level >= options.coarsest_level)
    return align(segment.reference, frame, guess, options, scratch, prior);
  AlignOptions coarse = options, fine = options;
  ++coarse.finest_level;
  fine.coarsest_level = fine.finest_level;
  const AlignResult begun = align(segment.reference, frame, guess, coarse, scratch, prior);
  frame.shutter.velocity = velocity_since(segment.state, begun.alignment.cur_from_ref, frame.stamp);
  AlignResult result = align(segment.reference, frame, begun.alignment, fine, scratch, prior);
  LevelList levels = begun.levels;
  for (const LevelStats& level : result.levels) levels.push_back(level);
  result.levels = levels;
  return result;
}

// Why a frame that was aligned so is lost, if it is.
LossCause cause_of(const AlignResult& result, const Segment& segment, const Frame& frame,
                   const SE3& predicted, const AlignOptions& options, AlignScratch& scratch) {
  const LossCause cause = loss_cause(result, options, segment.state, frame.stamp);
  if (cause != LossCause::kNone) return cause;
  const double fit = local_fit(result, segment.reference, frame, options, scratch);
  if (is_unlike(result, fit, segment.state)) return LossCause::kUnlike;
  return is_refuted_by_depth(result, segment.reference, frame, predicted, options, scratch)
             ? LossCause::kOutliers
             : LossCause::kNone;
}

// From the motion that corners tell.
AlignResult align_by_corners(Segment& segment, const Frame& frame, const Config& config,
                             AlignScratch& scratch) {
  const std::optional<SE3> motion = segment.corners.motion_to(frame);
  if (!motion) return {};
  Alignment guess = segment.state.alignment;
  guess.cur_from_ref = *motion;
  AlignOptions options = config.tracking;
  options.coarsest_level = std::min(options.coarsest_level, options.finest_level + kNearLevels - 1);
  return align(segment.reference, frame, guess, options, scratch, PositionPrior{});
}

// A search from far guesses, wherever the views still overlap: the alignment of least residuals.
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

// Where a frame is lost, and where it fits poorly, other motions are tried: that of corners, which
// may be a better one, and if it is lost, far ones.
void look_further(Segment& segment, const Frame& frame, const SE3& velocity, const SE3& predicted,
                  const Config& config, AlignScratch& scratch, AlignResult& result,
                  LossCause& loss) {
  const auto fit_of = [&](const AlignResult& r) {
    return local_fit(r, segment.reference, frame, config.tracking, scratch);
  };
  const auto is_good = [&](const AlignResult& r) {
    return cause_of(r, segment, frame, predicted, config.tracking, scratch) == LossCause::kNone;
  };
  const bool is_lost = loss != LossCause::kNone;
  const double fit = fit_of(result);
  if (!is_lost && !fits_poorly(fit)) return;
  AlignResult other = align_by_corners(segment, frame, config, scratch);
  const bool is_better =
      is_good(other) &&
      (is_lost || (!fits_poorly(fit_of(other)) && fit_of(other) > fit + kBetterFit));
  if (!is_better) {
    if (!is_lost) return;
    other = align_from_afar(segment, frame, velocity, config, scratch);
    if (!is_good(other)) return;
  }
  result = other;
  loss = LossCause::kNone;
}

// Keyframes get no points where something moves otherwise, and what is clearly seen to be such a
// point of the reference is left out from now on.
void accept_motion(Segment& segment, const JudgedMotion& judged) {
  TrackingState& state = segment.state;
  const bool are_two = judged.verdict != MotionVerdict::kOneMotion;
  const bool in_doubt = (are_two && !judged.is_clear) || segment.undecided_frames > 0;
  state.doubtful_frames = in_doubt ? kDoubtful : std::max(0, state.doubtful_frames - 1);
  segment.undecided_frames = 0;
  state.others = judged.others;
  if (!are_two || !judged.is_clear) return;
  segment.reference = points_outside(segment.reference, judged.cells, CellState::kUnexplained);
}

// Whether a result of large residuals brings less of the images together than another does.
bool fits_worse(const AlignResult& result, const AlignResult& other, const MotionEvidence& evidence,
                const AlignOptions& options, AlignScratch& scratch) {
  const Reference& reference = evidence.reference;
  return local_fit(result, reference, evidence.frame, options, scratch) <
         local_correlation(reference, evidence.frame, options.finest_level, other.alignment,
                           scratch);
}

// Takes the motion that the witness corrects a frame's to, or calls the frame lost.
void ask_witness(const Witness& witness, const MotionEvidence& evidence, const Config& config,
                 AlignScratch& scratch, SegmentAlignment& aligned) {
  const TrackingState& state = evidence.state;
  if (aligned.judged.verdict == MotionVerdict::kOneMotion && expects_one_motion(state) &&
      aligned.judged.explained >= kWellExplained)
    return;
  const Testimony said = question(witness, aligned.result, aligned.judged.explained, evidence,
                                  config.tracking, scratch);
  aligned.in_front = said.in_front;
  if (said.correction) {
    if (loss_cause(*said.correction, config.tracking, state, evidence.frame.stamp) !=
            LossCause::kNone ||
        (aligned.loss == LossCause::kNone &&
         fits_worse(*said.correction, aligned.result, evidence, config.tracking, scratch)))
      return;
    aligned.result = *said.correction;
    aligned.loss = LossCause::kNone;
  } else if (said.contradicts && aligned.loss == LossCause::kNone) {
    aligned.loss = LossCause::kTwoMotions;
  }
}

// Takes the motion that is the camera's, or calls the frame lost.
void judge(const Segment& segment, const MotionEvidence& evidence, const RestTest& rest,
           const Config& config, AlignScratch& scratch, SegmentAlignment& aligned) {
  aligned.judged = judge_motion(aligned.result, evidence, config.tracking, scratch);
  switch (aligned.judged.verdict) {
    case MotionVerdict::kOneMotion:
      break;
    case MotionVerdict::kFirst:
    case MotionVerdict::kSecond:
      aligned.result = aligned.judged.camera;
      break;
    case MotionVerdict::kUndecided:
      aligned.loss = LossCause::kTwoMotions;
      break;
    case MotionVerdict::kUnexplained:
      aligned.loss = LossCause::kOutliers;
      break;
  }
  if (rest.contradicts) aligned.loss = LossCause::kTwoMotions;
  if (segment.witness && !rest.alignment)
    ask_witness(*segment.witness, evidence, config, scratch, aligned);
}

}  // namespace

SegmentAlignment align_in(Segment& segment, Frame& frame, const Config& config,
                          const MovingObjectGuard& guard, AlignScratch& scratch) {
  TrackingState state = segment.state;
  const SE3 velocity = constant_velocity(state, frame.stamp);
  const PositionPrior prior = position_prior(state, frame.stamp, config.motion.acceleration);
  AlignResult result;
  const SE3 predicted = velocity * state.alignment.cur_from_ref;
  frame.shutter.velocity = velocity_since(state, predicted, frame.stamp);
  const MotionCandidates near = segment.predictor.candidates(frame, velocity, config, scratch);
  for (const Alignment& guess : guesses(segment, frame, near, config, scratch)) {
    result = align_by_rows(segment, frame, guess, config.tracking, scratch, prior);
    if (result.status == AlignStatus::kTracked) break;
  }
  result = guard.check(result, segment.reference, frame, velocity, prior, state, scratch);
  const RestTest rest =
      test_rest(result, segment.reference, frame, sigma_baseline(state), config.tracking, scratch);
  if (rest.alignment) result = *rest.alignment;
  LossCause loss = cause_of(result, segment, frame, predicted, config.tracking, scratch);
  const LossCause fault = loss == LossCause::kNone ? loss : image_fault(frame, config.selection);
  if (fault != LossCause::kNone) {
    loss = fault;
  } else {
    look_further(segment, frame, velocity, predicted, config, scratch, result, loss);
  }
  SegmentAlignment aligned = {
      .result = result, .loss = loss, .moving_object_frames = state.moving_object_frames};
  if (loss != LossCause::kNone) {
    frame.shutter.velocity.setZero();
    return aligned;
  }
  const MotionEvidence evidence = {.reference = segment.reference,
                                   .frame = frame,
                                   .candidates = near,
                                   .predicted = predicted,
                                   .state = state,
                                   .is_at_rest = rest.alignment.has_value(),
                                   .undecided_frames = segment.undecided_frames};
  judge(segment, evidence, rest, config, scratch, aligned);
  frame.shutter.velocity =
      aligned.loss == LossCause::kNone
          ? velocity_since(state, aligned.result.alignment.cur_from_ref, frame.stamp)
          : Vector6d::Zero();
  return aligned;
}

void update_tracking_state(Segment& segment, const Frame& frame,
                           const SegmentAlignment& alignment) {
  TrackingState& state = segment.state;
  const AlignResult& result = alignment.result;
  state.last_from_current = state.alignment.cur_from_ref * inverse(result.alignment.cur_from_ref);
  state.motion_seconds = seconds_between(*state.stamp, frame.stamp);
  state.stamp = frame.stamp;
  state.alignment = result.alignment;
  state.moving_object_frames = alignment.moving_object_frames;
  state.in_front = alignment.in_front;
  accept_motion(segment, alignment.judged);
  // Residuals of something that moves otherwise are not usual ones.
  if (state.usual_sigma == 0 || state.doubtful_frames == 0 || result.sigma < state.usual_sigma ||
      alignment.judged.explained > kWellExplained)
    state.usual_sigma +=
        (state.usual_sigma > 0 ? kUsualShare : 1.0) * (result.sigma - state.usual_sigma);
  state.low_sigma =
      state.low_sigma > 0 ? std::min(kLowGrowth * state.low_sigma, result.sigma) : result.sigma;
  state.keyframe_sigma =
      state.keyframe_sigma > 0 ? std::min(state.keyframe_sigma, result.sigma) : result.sigma;
  ++state.frames_since_keyframe;
  ++segment.tracked;
}

}  // namespace edvo
