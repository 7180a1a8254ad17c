// SPDX-License-Identifier: MIT
// One connected part of the trajectory: what is needed to track on in it.
#pragma once

#include "edvo/map/map.hpp"
#include "edvo/odometry/frame_result.hpp"
#include "edvo/odometry/motion_judge.hpp"
#include "edvo/odometry/motion_predictor.hpp"
#include "edvo/odometry/moving_object_guard.hpp"
#include "edvo/odometry/tracking_state.hpp"
#include "edvo/window/keyframe_window.hpp"

namespace edvo {

struct Segment {
  int id = 0;
  std::int64_t tracked = 0;  // frames
  KeyframeId keyframe = -1;  // the reference
  Reference reference;       // of that keyframe
  TrackingState state;
  int undecided_frames = 0;  // lost since the last good one to a second motion
  MotionPredictor predictor;
  KeyframeWindow window;
};

struct SegmentAlignment {
  AlignResult result;
  LossCause loss = LossCause::kNone;
  int moving_object_frames = 0;  // for the state, should the frame be taken
  JudgedMotion judged;
};

// Aligns a frame to the segment's reference keyframe, from where the motion so far leads, and
// judges the result. Changes nothing that the next frame reads: a lost frame leaves no trace.
[[nodiscard]] SegmentAlignment align_in(Segment& segment, const Frame& frame, const Config& config,
                                        const MovingObjectGuard& guard, AlignScratch& scratch);

// Takes a tracked frame over into the segment's state.
void accept(Segment& segment, const Frame& frame, const SegmentAlignment& alignment);

}  // namespace edvo
