// SPDX-License-Identifier: MIT
#include "edvo/odometry/odometry.hpp"

#include "edvo/odometry/loss_test.hpp"
#include "edvo/odometry/odometry_state.hpp"

#include <limits>
#include <utility>

namespace edvo {
namespace {

Frame without_depth(Frame frame) {
  frame.depth = cv::Mat_<float>(frame.depth.size(), std::numeric_limits<float>::quiet_NaN());
  return frame;
}

}  // namespace

FrameResult Odometry::process(const PreparedImage& image) {
  State& s = *state_;
  const bool is_constant = has_constant_depth(image.frame, s.config.selection);
  const Frame emptied = is_constant ? without_depth(image.frame) : Frame();
  const Frame& frame = is_constant ? emptied : image.frame;
  s.require_newer(frame.stamp);
  FrameResult result{.index = s.images++, .stamp = frame.stamp};
  Stopwatch total;

  if (s.segment.keyframe < 0) {
    s.begin(frame, KeyframeReason::kFirst, result);
  } else {
    // Align to the reference keyframe; where that fails, to the segment that was left before.
    Stopwatch watch;
    SegmentAlignment alignment = align_in(s.segment, frame, s.config, s.guard, s.scratch);
    const bool relocalized = alignment.loss != LossCause::kNone && s.relocalize(frame, alignment);
    result.milliseconds.tracking = watch.lap();

    // Refine the keyframe before: what a keyframe costs is shared by the frames after it.
    s.refine();
    result.milliseconds.window = watch.lap();

    describe(alignment.result, result);
    if (alignment.loss != LossCause::kNone) {
      s.lose(frame, alignment.loss, result);
    } else {
      accept(s.segment, frame, alignment);
      s.take(frame, alignment.result, relocalized, result);
      if (const auto reason = s.policy.due(alignment.result, frame, s.segment.state))
        (void)s.insert_keyframe(frame, *reason, result);
      s.segment.predictor.update(frame, s.config);
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

void Odometry::settle() {
  while (state_->refine()) {
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
  return state_->newest_keyframe();
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
