// SPDX-License-Identifier: MIT
// Keeps the odometry from following a large object that moves on its own.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/odometry/tracking_state.hpp"

namespace edvo {

class MovingObjectGuard {
 public:
  explicit MovingObjectGuard(const AlignOptions& options) : options_(options) {}

  // The alignment to believe: the first, or one found again at fine levels with a loss that ignores
  // outliers, if residuals are large, the motion is sudden or a second motion was seen lately.
  // velocity: current_from_last, constant. Counts state.moving_object_frames.
  [[nodiscard]] AlignResult check(const AlignResult& first, const Reference& reference,
                                  const Frame& frame, const SE3& velocity,
                                  const PositionPrior& prior, TrackingState& state,
                                  AlignScratch& scratch) const;

 private:
  [[nodiscard]] AlignResult retrack_robust(const Reference& reference, const Frame& frame,
                                           const Alignment& predicted, const Alignment& last,
                                           const PositionPrior& prior, AlignScratch& scratch) const;

  AlignOptions options_;
};

}  // namespace edvo
