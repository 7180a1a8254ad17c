// SPDX-License-Identifier: MIT
// Whether the motion that a frame was aligned by is the camera's. Something large that moves on its
// own, or dirt on the lens, is aligned to as well as the scene is, or better if it has more
// texture.
#pragma once

#include "edvo/align/motion_support.hpp"
#include "edvo/odometry/motion_predictor.hpp"
#include "edvo/odometry/tracking_state.hpp"

namespace edvo {

enum class MotionVerdict {
  kOneMotion,    // nothing speaks against it
  kFirst,        // there are two; the first is the camera's
  kSecond,       // there are two; the second is
  kUndecided,    // there are two, and nothing tells which is the camera's
  kUnexplained,  // too little of the image is explained, and by nothing else
};

struct JudgedMotion {
  MotionVerdict verdict = MotionVerdict::kOneMotion;
  AlignResult camera;     // alignment of the camera's motion, if decided
  double explained = 1;   // [0..1] of the image's area, by the first
  CellStates cells{};     // of the reference, by the camera's motion; if there are two
  CellMask others{};      // cells of the frame in which the other motion is; if decided
  bool is_clear = false;  // decided beyond doubt
};

// What a frame's motion is judged by.
struct MotionEvidence {
  const Reference& reference;
  const Frame& frame;
  const MotionCandidates& candidates;  // current_from_last, where a second motion may be found
  SE3 predicted;                       // cur_from_ref, at constant velocity
  const TrackingState& state;
  bool is_at_rest = false;   // the first motion is that of what stands still (RestTest)
  int undecided_frames = 0;  // lost since the last good frame because nothing was decided
};

// Largest residual that fits: 3 sigmas, the usual or the frame's, whichever is less; usual_sigma 0:
// none is known. [grey levels]
[[nodiscard]] double largest_fitting(double sigma, double usual_sigma);

// How much of the reference a motion explains, by residuals up to `largest` [grey levels].
[[nodiscard]] MotionSupport support_within(double largest, const Reference& reference,
                                           const Frame& frame, const Alignment& alignment,
                                           const AlignOptions& options, AlignScratch& scratch);

// Whether a motion far off the predicted cur_from_ref is refuted by depth: hardly any surface is
// where it would be then. Intensities alone fit a pattern that repeats, or little texture, in many
// places.
[[nodiscard]] bool is_refuted_by_depth(const AlignResult& result, const Reference& reference,
                                       const Frame& frame, const SE3& predicted,
                                       const AlignOptions& options, AlignScratch& scratch);

[[nodiscard]] JudgedMotion judge_motion(const AlignResult& first, const MotionEvidence& evidence,
                                        const AlignOptions& options, AlignScratch& scratch);

}  // namespace edvo
