// SPDX-License-Identifier: MIT
// What tracking knows of the last good frame. A value: going back to an earlier state is an
// assignment, and a lost frame leaves it as it is.
#pragma once

#include "edvo/align/motion_support.hpp"
#include "edvo/align/photometric.hpp"
#include "edvo/core/stamp.hpp"

#include <algorithm>
#include <optional>

namespace edvo {

struct TrackingState {
  std::optional<Stamp> stamp;     // of the last good frame
  Alignment alignment;            // of that frame to the reference keyframe
  SE3 last_from_current;          // motion from the good frame before to it
  double motion_seconds = 0;      // that this took, 0 = not known [s]
  double usual_sigma = 0;         // of tracked frames' residuals, 0 = none yet [grey levels]
  double low_sigma = 0;           // the least of the last frames, which grows by 2 % per frame
  double keyframe_sharpness = 0;  // of the reference keyframe's image [grey levels^2]
  int frames_since_keyframe = 0;
  double keyframe_sigma = 0;     // least sigma of the frames since then, 0 = none [grey levels]
  int moving_object_frames = 0;  // for which a second motion in the image is still expected
  int doubtful_frames = 0;       // for which a sudden motion may be that of something else
  double in_front = 0;           // [0..1] of what the last good frame saw, as Testimony has it
  CellMask others{};             // cells of the last good frame that move otherwise
};

// Whether nothing was seen in the last frames that moves otherwise.
[[nodiscard]] inline bool expects_one_motion(const TrackingState& state) {
  return state.moving_object_frames == 0 && state.doubtful_frames == 0;
}

// Whether so long after the last good frame [s] its motion tells nothing any more.
[[nodiscard]] inline bool is_far_ahead(const TrackingState& last, double seconds) {
  constexpr double kTimes = 3;  // the duration of that motion
  return seconds > kTimes * last.motion_seconds;
}

// Above this an alignment may have missed the best fit: the usual sigma grows with wrong poses, the
// low one does not. 0 = none yet. [grey levels]
[[nodiscard]] inline double expected_sigma(const TrackingState& state) {
  constexpr double kAboveLow = 2;
  return std::min(state.usual_sigma, kAboveLow * state.low_sigma);
}

// What residuals are compared with: the usual sigma, but not that of a camera at rest, whose images
// differ by noise alone. [grey levels]
[[nodiscard]] inline double sigma_baseline(const TrackingState& state) {
  constexpr double kLeast = 8;
  return std::max(state.usual_sigma, kLeast);
}

}  // namespace edvo
