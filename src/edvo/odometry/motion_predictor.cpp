// SPDX-License-Identifier: MIT
#include "edvo/odometry/motion_predictor.hpp"

#include "edvo/align/surface.hpp"

#include <algorithm>
#include <utility>

namespace edvo {
namespace {

constexpr double kLeastSeconds = 1e-3;  // [s] stamps nearer to each other are not a camera's

// Rotations that are tried where a frame is lost: so many steps to each side.
constexpr double kFarStep =
    0.14;  // [rad] alignment at the coarsest level converges from half of it
constexpr int kFarSteps = 3;

constexpr int kFinestLevel = 3, kCoarsestLevel = 5;
constexpr double kCoarseStep = 0.05;     // [px of the level] ends a level: only a guess is wanted
constexpr int kGridStep = 16;            // [px] between points of the whole image
constexpr int kCorrelationColumns = 40;  // [px] an image to be correlated needs

AlignOptions coarse_tracking(const Config& config) {
  AlignOptions options = config.tracking;
  options.finest_level = kFinestLevel;
  options.coarsest_level = kCoarsestLevel;
  options.step_tolerance = kCoarseStep;
  return options;
}

// The coarsest level whose image is large enough to correlate.
const Level& correlation_level(const Frame& frame) {
  std::size_t level = 0;
  while (level + 1 < frame.levels.size() &&
         frame.levels[level + 1].gray.cols >= kCorrelationColumns)
    ++level;
  return frame.levels[level];
}

}  // namespace

SE3 constant_velocity(const TrackingState& state, const Stamp& stamp) {
  if (!state.stamp || state.motion_seconds <= 0) return SE3{};
  const double gap = seconds_between(*state.stamp, stamp);
  if (is_far_ahead(state, gap)) return SE3{};
  return exp(gap / state.motion_seconds * log(inverse(state.last_from_current)));
}

PositionPrior position_prior(const TrackingState& state, const Stamp& stamp, double acceleration) {
  if (acceleration == 0 || !state.stamp || state.motion_seconds <= 0) return {};
  const double gap = seconds_between(*state.stamp, stamp);
  if (is_far_ahead(state, gap)) return {};
  const SE3 key_from_last = inverse(state.alignment.cur_from_ref);
  const SE3 current_from_last = inverse(state.last_from_current);
  const Eigen::Vector3d onward = current_from_last.rotation * state.last_from_current.translation *
                                 (gap / state.motion_seconds);
  return {.centre = key_from_last * onward,
          .sigma = acceleration * std::max(gap, kLeastSeconds) *
                   std::max({gap, state.motion_seconds, kLeastSeconds})};
}

MotionCandidates MotionPredictor::candidates(const Frame& frame, const SE3& velocity,
                                             const Config& config, AlignScratch& scratch) {
  const AlignOptions options = coarse_tracking(config);
  const Level& level = correlation_level(frame);
  const SE3 rotation = rotation_from_image_shift(correlation_.shift_to(level.gray), level.camera);
  Alignment start{.cur_from_ref = velocity};
  double least = coarse_cost(last_, frame, start, options, scratch);
  for (const SE3& other : {SE3{}, rotation}) {
    const Alignment guess{.cur_from_ref = other};
    const double cost = coarse_cost(last_, frame, guess, options, scratch);
    if (cost < least) {
      start = guess;
      least = cost;
    }
  }
  const AlignResult coarse = align(last_, frame, start, options, scratch);
  if (coarse.status != AlignStatus::kTracked) return {velocity, SE3{}};
  return {coarse.alignment.cur_from_ref, velocity, SE3{}};
}

MotionCandidates MotionPredictor::far_candidates(const Frame& frame, const SE3& velocity,
                                                 const Config& config,
                                                 AlignScratch& scratch) const {
  const AlignOptions options = coarse_tracking(config);
  std::vector<SE3> starts = {velocity, SE3{}};
  for (int yaw = -kFarSteps; yaw <= kFarSteps; ++yaw)
    for (int pitch = -kFarSteps; pitch <= kFarSteps; ++pitch)
      for (int roll = -1; roll <= 1; ++roll)
        starts.push_back(exp(
            (Vector6d() << 0, 0, 0, kFarStep * pitch, kFarStep * yaw, kFarStep * roll).finished()));
  std::vector<std::pair<double, std::size_t>> costs;  // and whose
  for (const SE3& start : starts)
    costs.push_back(
        {coarse_cost(last_, frame, {.cur_from_ref = start}, options, scratch), costs.size()});
  std::sort(costs.begin(), costs.end());
  MotionCandidates best;
  for (std::size_t i = 0; i < kMostCandidates && i < costs.size(); ++i) {
    const SE3& start = starts[costs[i].second];
    const AlignResult coarse = align(last_, frame, {.cur_from_ref = start}, options, scratch);
    best.push_back(coarse.status == AlignStatus::kTracked ? coarse.alignment.cur_from_ref : start);
  }
  return best;
}

void MotionPredictor::update(const Frame& frame, const Config& config) {
  correlation_.set_reference(correlation_level(frame).gray);
  pixels_ = grid_pixels(frame, kGridStep, config.selection, std::move(pixels_));
  last_ = make_reference(
      frame, pixels_,
      {.gradient_weight_scale = config.tracking.gradient_weight_scale,
       .finest_level = std::min(kFinestLevel, static_cast<int>(frame.levels.size()) - 1),
       .coarsest_level = kCoarsestLevel},
      std::move(last_));
  if (config.tracking.depth_weight > 0)
    last_.surface = make_surface(frame.depth, frame.levels.front().camera, 2 * kGridStep,
                                 config.tracking.depth_noise, std::move(last_.surface));
}

}  // namespace edvo
