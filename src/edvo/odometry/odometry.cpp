// SPDX-License-Identifier: MIT
#include "edvo/odometry/odometry.hpp"

#include "edvo/odometry/loss_test.hpp"
#include "edvo/odometry/odometry_state.hpp"

#include <limits>
#include <utility>

namespace edvo {
namespace {

// Copies the image, but not its pixels, into the memory of the one before. Depth that is the same
// everywhere was not measured: it is taken as missing.
Frame& take_over(const Frame& image, bool is_constant, Frame& frame) {
  frame = image;
  if (is_constant)
    frame.depth = cv::Mat_<float>(frame.depth.size(), std::numeric_limits<float>::quiet_NaN());
  return frame;
}

}  // namespace

// Refinement comes before the pose is recorded: the world pose reported is the refined keyframe's
// times the frame's motion from it.
FrameResult Odometry::process(const PreparedImage& image) {
  State& s = *state_;
  const bool is_constant = has_constant_depth(image.frame, s.config.selection);
  Frame& frame = take_over(image.frame, is_constant, s.current_frame);
  s.require_newer(frame.stamp);
  FrameResult result{.index = s.images++, .stamp = frame.stamp};  // kLost until a step changes it
  result.readout_seconds = frame.shutter.readout_seconds = s.readout.seconds();
  Stopwatch total;

  s.leave_out_own(frame);
  result.ego_share = share_of(s.ego.cells());
  if (s.segment.keyframe < 0) {
    // Where too little of the frame can be tracked it is lost, and the next frame tries again.
    s.begin_segment(frame, KeyframeReason::kFirst, result);
  } else {
    // Align to the reference keyframe: from predicted motions, again where an object may move, from
    // far motions if lost; judge, in doubt by an older keyframe, if the motion is the camera's.
    // If lost, align to the segment left last; where that fits, segment and alignment are its own.
    Stopwatch watch;
    SegmentAlignment alignment = align_in(s.segment, frame, s.config, s.guard, s.scratch);
    const bool relocalized = alignment.loss != LossCause::kNone && s.relocalize(frame, alignment);
    result.milliseconds.tracking = watch.lap();

    // A few steps of the window's bundle adjustment, for a lost frame too: frames after a keyframe
    // share its cost.
    s.refine_window();
    result.milliseconds.window = watch.lap();

    describe(alignment.result, result);  // statistics
    if (alignment.loss != LossCause::kNone) {
      s.lose_or_restart(frame, alignment.loss, result);  // last good pose; in time a new segment
    } else {
      update_tracking_state(s.segment, frame, alignment);  // points clearly on others go
      s.record_tracked(frame, alignment.result, relocalized, result);
      // May fail for want of points: the frame stays tracked, and the next one is asked again.
      if (const auto reason = s.policy.due(alignment.result, frame, s.segment.state))
        (void)s.insert_keyframe(frame, *reason, result);
      s.segment.predictor.update(frame, s.config);  // motion to expect next
    }
  }

  if (is_constant && result.loss_cause == LossCause::kNoDepth)
    result.loss_cause = LossCause::kConstantDepth;
  result.milliseconds.frame = image.milliseconds;
  result.milliseconds.total = image.milliseconds + total.lap();
  return result;
}

FrameResult Odometry::process(const RgbdImage& image) {
  return process(prepare(image));
}

PreparedImage Odometry::prepare(const RgbdImage& image) const {
  require_fitting(image, state_->undistortion.camera);
  Stopwatch watch;
  PreparedImage prepared{.frame =
                             make_frame(image, state_->undistortion, level_count(state_->config))};
  prepared.milliseconds = watch.lap();
  return prepared;
}

// Only the present segment's window: that of one left keeps what is still to refine in it.
void Odometry::settle() {
  while (state_->refine_window()) {
  }
}

void Odometry::correct(std::span<const MapKeyframe> keyframes) {
  state_->correct(keyframes);
}

void Odometry::finish(int threads) {
  settle();
  state_->refine_all(threads);
}

void Odometry::reset() {
  auto fresh = std::make_unique<State>(state_->config, std::move(state_->undistortion));
  fresh->detector = std::move(state_->detector);
  state_ = std::move(fresh);
}

Trajectory Odometry::trajectory() const {
  Trajectory all;
  all.reserve(state_->links.size());
  for (const FrameLink& link : state_->links) {
    const MapKeyframe& key = state_->map[link.keyframe];
    // A segment in which nothing was tracked is one guessed pose.
    if (link.is_guess && !state_->has_tracked(key.segment)) continue;
    all.push_back({.stamp = link.stamp,
                   .world_from_camera = state_->world_from_camera(link),
                   .segment = key.segment});
  }
  return all;
}

Trajectory Odometry::keyframe_trajectory() const {
  Trajectory all;
  for (const MapKeyframe& key : state_->map.keyframes())
    all.push_back(
        {.stamp = key.stamp, .world_from_camera = key.world_from_camera, .segment = key.segment});
  return all;
}

const Map& Odometry::map() const {
  return state_->map;
}

KeyframePtr Odometry::newest_keyframe() const {
  return state_->newest_keyframe(true);
}

KeyframePtr Odometry::newest_keyframe_in_gray() const {
  return state_->newest_keyframe(false);
}

Odometry::Odometry(const DistortedCamera& camera, const Config& config,
                   std::unique_ptr<EdgeDetector> detector)
    : state_(std::make_unique<State>(config, make_undistortion(camera))) {
  state_->detector = detector ? std::move(detector) : make_detector(config);
}

Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

}  // namespace edvo
