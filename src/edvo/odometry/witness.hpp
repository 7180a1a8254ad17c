// SPDX-License-Identifier: MIT
// An older keyframe that saw the scene before something began to move in front of it. Who follows
// what moves leaves the witness's view, or loses what it saw.
#pragma once

#include "edvo/odometry/motion_judge.hpp"

#include <optional>

namespace edvo {

struct Witness {
  Reference reference;   // of the older keyframe
  Alignment alignment;   // of the present reference keyframe to the older one
  double explained = 1;  // [0..1] of the older one's image, by the keyframe that came after it
};

struct Testimony {
  double in_front = 0;       // [0..1] of the depth seen, of something that the witness did not see
  bool contradicts = false;  // the frame's motion is not the camera's
  std::optional<AlignResult> correction;  // the camera's motion, to the present reference keyframe
};

// What the witness says of a frame that was aligned to the present reference keyframe by `result`,
// where something else may move. explained: of the present one's image, by that motion.
[[nodiscard]] Testimony question(const Witness& witness, const AlignResult& result,
                                 double explained, const MotionEvidence& evidence,
                                 const AlignOptions& options, AlignScratch& scratch);

// Whether something has come in front of what the reference shows: much of the depth measured is
// nearer than expected, and far less of it is farther.
[[nodiscard]] bool is_hidden(const Reference& reference, const Frame& frame,
                             const SE3& cur_from_ref, const AlignOptions& options,
                             AlignScratch& scratch);

// Call it when a frame becomes the next reference keyframe, with the present one's points and the
// alignment to it (state's). Where nothing else moves, the present one may take over as witness.
void hand_over(std::optional<Witness>& witness, const Reference& present, const Frame& frame,
               const TrackingState& state, const AlignOptions& options, AlignScratch& scratch);

}  // namespace edvo
