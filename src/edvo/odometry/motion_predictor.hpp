// SPDX-License-Identifier: MIT
// Guesses of the camera's motion since the last good frame: initial values for the alignment.
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

// Motion from the last good frame to the stamp at constant velocity (current_from_last). The
// identity if the gap is too long to extrapolate over.
[[nodiscard]] SE3 constant_velocity(const TrackingState& state, const Stamp& stamp);

// Expected position of the camera centre at the stamp, in the frame of the reference keyframe's
// camera [m], with the sigma [m] that follows from the acceleration [m/s^2]; sigma 0 = no prior.
[[nodiscard]] PositionPrior position_prior(const TrackingState& state, const Stamp& stamp,
                                           double acceleration);

// Aligns each whole coarse image to that of the last good frame.
class MotionPredictor {
 public:
  // Three guesses: the result of aligning whole coarse images, the constant velocity, and no
  // motion. The coarse alignment starts from the constant velocity, from no motion or from the
  // rotation found by phase correlation, whichever has the lowest cost. velocity:
  // current_from_last.
  [[nodiscard]] MotionCandidates candidates(const Frame& frame, const SE3& velocity,
                                            const Config& config, AlignScratch& scratch);

  // Guesses for a frame for which candidates() failed: rotations over the whole range that leaves
  // some overlap are compared by their cost, and the best are aligned. Lowest cost first.
  [[nodiscard]] MotionCandidates far_candidates(const Frame& frame, const SE3& velocity,
                                                const Config& config, AlignScratch& scratch) const;

  // Makes this frame the one to which later frames are aligned.
  void update(const Frame& frame, const Config& config);

 private:
  std::vector<SelectedPixel> pixels_;  // of the last good frame, on a grid
  Reference last_;                     // the last good frame, whole but coarse
  PhaseCorrelation correlation_;       // with its image
};

}  // namespace edvo
