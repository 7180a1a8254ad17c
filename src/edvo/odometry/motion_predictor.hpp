// SPDX-License-Identifier: MIT
// Where the camera could have moved since the last good frame: starts for the alignment.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/align/image_shift.hpp"
#include "edvo/core/inplace_vector.hpp"
#include "edvo/features/pixel_selection.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/odometry/tracking_state.hpp"

namespace edvo {

constexpr std::size_t kMostCandidates = 6;
using MotionCandidates = InplaceVector<SE3, kMostCandidates>;  // current_from_last

// Motion from the last good frame to a stamp, if the camera goes on as it did; none (the identity)
// where the gap is so long that the last motion tells nothing. current_from_last.
[[nodiscard]] SE3 constant_velocity(const TrackingState& state, const Stamp& stamp);

// Where the camera's centre is expected at a stamp, in the reference keyframe's camera, with the
// sigma that this acceleration [m/s^2] allows; sigma 0 = nothing is expected.
[[nodiscard]] PositionPrior position_prior(const TrackingState& state, const Stamp& stamp,
                                           double acceleration);

// Aligns whole coarse images, each to that of the last good frame.
class MotionPredictor {
 public:
  // The motion that whole coarse images show (found from the constant velocity, from no motion or
  // from the rotation that phase correlation shows, whichever costs least), the constant velocity,
  // and no motion.
  [[nodiscard]] MotionCandidates candidates(const Frame& frame, const SE3& velocity,
                                            const Config& config, AlignScratch& scratch);

  // Where a frame that these do not lead to could be: rotations over the whole range that leaves a
  // view in common are tried by their cost, the best are aligned. The likeliest first.
  [[nodiscard]] MotionCandidates far_candidates(const Frame& frame, const SE3& velocity,
                                                const Config& config, AlignScratch& scratch) const;

  // Makes this frame the one that later frames are aligned to.
  void update(const Frame& frame, const Config& config);

 private:
  std::vector<SelectedPixel> pixels_;  // of the last good frame, on a grid
  Reference last_;                     // the last good frame, whole but coarse
  PhaseCorrelation correlation_;       // with its image
};

}  // namespace edvo
