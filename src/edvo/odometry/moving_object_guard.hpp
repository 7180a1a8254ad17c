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

  // Returns the first alignment, or a second one found at fine levels with Tukey's loss. The second
  // is computed if residuals are large, the motion is sudden or a second motion was seen in the
  // last frames, and returned if it fits better. velocity: current_from_last at constant velocity.
  // Updates state.moving_object_frames.
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
