// SPDX-License-Identifier: MIT
#include "edvo/odometry/motion_predictor.hpp"

#include "edvo/align/surface.hpp"

#include <algorithm>
#include <utility>

namespace edvo {
namespace {

constexpr double kCoarseStep = 0.05;  // [px of the level] ends a level: only a guess is wanted
constexpr int kTurnColumns = 40;      // [px] an image to be correlated needs

AlignOptions coarse_tracking(const Config& config) {
  AlignOptions options = config.tracking;
  options.finest_level = config.coarse.finest_level;
  options.coarsest_level = config.coarse.coarsest_level;
  options.step_tolerance = kCoarseStep;
  options.edge_distance = 0;  // its points are a grid's, not edges'
  return options;
}

// The coarsest whose image is large enough to correlate.
std::size_t turn_level(const Frame& frame) {
  std::size_t level = 0;
  while (level + 1 < frame.levels.size() && frame.levels[level + 1].gray.cols >= kTurnColumns)
    ++level;
  return level;
}

}  // namespace

SE3 MotionPredictor::turn_to(const Frame& frame) {
  const Level& level = frame.levels[turn_level(frame)];
  return rotation_from_image_shift(correlation_.shift_to(level.gray), level.camera);
}

Motions MotionPredictor::likely(const Frame& frame, const SE3& going_on, const Config& config,
                                AlignScratch& scratch) {
  const AlignOptions options = coarse_tracking(config);
  Alignment start{.cur_from_ref = going_on};
  double least = coarse_cost(last_, frame, start, options, scratch);
  for (const SE3& other : {SE3{}, turn_to(frame)}) {
    const Alignment guess{.cur_from_ref = other};
    const double cost = coarse_cost(last_, frame, guess, options, scratch);
    if (cost < least) {
      start = guess;
      least = cost;
    }
  }
  const AlignResult coarse = align(last_, frame, start, options, scratch);
  if (coarse.status != AlignStatus::kTracked) return {going_on, SE3{}};
  return {coarse.alignment.cur_from_ref, going_on, SE3{}};
}

void MotionPredictor::remember(const Frame& frame, const Config& config) {
  if (last_.levels.empty()) (void)turn_to(frame);  // the first: nobody has asked
  pixels_ = grid_pixels(frame, config.coarse.step, config.selection, std::move(pixels_));
  last_ = make_reference(frame, pixels_,
                         {.gradient_weight_scale = config.tracking.gradient_weight_scale,
                          .finest_level = std::min(config.coarse.finest_level,
                                                   static_cast<int>(frame.levels.size()) - 1),
                          .coarsest_level = config.coarse.coarsest_level},
                         std::move(last_));
  if (config.tracking.depth_weight > 0)
    last_.surface = make_surface(frame.depth, frame.levels.front().camera, 2 * config.coarse.step,
                                 config.tracking.depth_noise, std::move(last_.surface));
}

}  // namespace edvo
