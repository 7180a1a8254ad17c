// SPDX-License-Identifier: MIT
// A segment: frames and keyframes whose motion between each other is known, and what it takes to
// track the next frame in it. A new one begins where tracking was lost for too long.
#pragma once

#include "edvo/map/map.hpp"
#include "edvo/odometry/frame_result.hpp"
#include "edvo/odometry/keyframe_corners.hpp"
#include "edvo/odometry/motion_judge.hpp"
#include "edvo/odometry/motion_predictor.hpp"
#include "edvo/odometry/moving_object_guard.hpp"
#include "edvo/odometry/tracking_state.hpp"
#include "edvo/odometry/witness.hpp"
#include "edvo/window/keyframe_window.hpp"

namespace edvo {

struct Segment {
  int id = 0;
  std::int64_t tracked = 0;  // frames, without the one that began it
  KeyframeId keyframe = -1;  // the reference keyframe: the newest of this segment
  Reference reference;       // its points, which frames are aligned to
  KeyframeCorners corners;   // of its image
  TrackingState state;
  int undecided_frames = 0;  // lost since the last good one to a second motion
  MotionPredictor predictor;
  KeyframeWindow window;
  std::optional<Witness> witness;  // none before the second keyframe
};

struct SegmentAlignment {
  AlignResult result;
  LossCause loss = LossCause::kNone;
  int moving_object_frames = 0;  // for TrackingState, if the frame is not lost
  JudgedMotion judged;
  double in_front = 0;  // the same: see Testimony
};

// Aligns a frame to the segment's reference keyframe: from predicted motions; tested for loss; if
// lost though the image is usable, once more from far guesses; and judged for a second motion,
// which may be an object's; where there may be one, the witness is asked. Changes nothing that the
// next frame reads: a lost frame leaves no trace. Sets the frame's velocity.
[[nodiscard]] SegmentAlignment align_in(Segment& segment, Frame& frame, const Config& config,
                                        const MovingObjectGuard& guard, AlignScratch& scratch);

// Makes a tracked frame the last good one: what the next is predicted from and judged by.
void update_tracking_state(Segment& segment, const Frame& frame, const SegmentAlignment& alignment);

}  // namespace edvo
