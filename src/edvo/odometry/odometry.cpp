// SPDX-License-Identifier: MIT
#include "edvo/odometry/odometry.hpp"

#include <chrono>
#include "edvo/track/selection.hpp"

namespace edvo {
namespace {

struct Keyframe {
  Stamp stamp;
  SE3 world_from_key;
  Reference reference;
};

struct FrameLink {
  Stamp stamp;
  std::size_t keyframe = 0;
  SE3 key_from_camera;
};

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

struct Odometry::State {
  Config config;
  Undistortion undistortion;
  std::unique_ptr<EdgeDetector> network;  // only where the options ask for one
  std::vector<Keyframe> keyframes;
  std::vector<WindowKeyframe> window;
  std::vector<FrameLink> frames;
  Alignment last;  // of the last frame to the current keyframe
  SE3 motion;      // previous camera from last camera
  int frames_since_keyframe = 0;
  std::int64_t index = 0;

  cv::Mat_<std::uint8_t> candidate_mask(const Frame& frame) const {
    if (config.edge.detector == Detector::kNone)
      return cv::Mat_<std::uint8_t>(frame.depth.size(), std::uint8_t{255});
    cv::Mat_<std::uint8_t> mask =
        network ? network_edges(network->detect(undistort_colour(undistortion, frame.bgr)),
                                config.network)
                : canny_edges(frame.levels[0].gray, config.canny);
    if (config.corners.enabled) {
      cv::Mat_<float> strength;
      mask.convertTo(strength, CV_32F, 1.0 / 255);
      mask |= draw_discs(mask.size(), optimize_corners(strength, config.corners),
                         config.corners.disc_radius);
    }
    return mask;
  }

  void add_keyframe(const Frame& frame, const SE3& world_from_camera, StageTimes& times) {
    Stopwatch watch;
    const cv::Mat_<std::uint8_t> mask = candidate_mask(frame);
    times.edges = watch.lap();
    const auto pixels = select_pixels(frame, mask, undistortion.valid, config.selection);
    keyframes.push_back(
        {frame.stamp, world_from_camera, make_reference(frame, pixels, config.tracking.softness)});
    times.selection = watch.lap();
    if (config.window.keyframes > 0) {
      SelectOptions fewer = config.selection;
      fewer.max_points = config.window.points;
      window.push_back(make_window_keyframe(frame, world_from_camera,
                                            select_pixels(frame, mask, undistortion.valid, fewer),
                                            config.window));
      refine();
    }
    times.window = watch.lap();
    last = {};
    frames_since_keyframe = 0;
    frames.back().keyframe = keyframes.size() - 1;
    frames.back().key_from_camera = {};
  }

  void refine() {
    const std::size_t count = window.size();
    const std::size_t recent = std::min(count, static_cast<std::size_t>(config.window.keyframes));
    std::vector<std::pair<double, std::size_t>> candidates;
    const std::size_t oldest = count - recent;
    for (std::size_t k = oldest > static_cast<std::size_t>(config.window.memory)
                             ? oldest - static_cast<std::size_t>(config.window.memory)
                             : 0;
         k < oldest; ++k) {
      window[k].image.release();
      const double view = shared_view(window.back(), window[k], undistortion.camera);
      if (view > 0.3) candidates.push_back({-view, k});
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(config.window.anchors)));
    std::vector<std::size_t> members;
    for (const auto& c : candidates) members.push_back(c.second);
    std::sort(members.begin(), members.end());
    const int fixed = std::max<int>(1, static_cast<int>(members.size()));
    for (std::size_t k = oldest; k < count; ++k) members.push_back(k);
    std::vector<WindowKeyframe> active;
    for (const std::size_t m : members) active.push_back(std::move(window[m]));
    refine_window(active, undistortion.camera, fixed, config.window);
    for (std::size_t a = 0; a < members.size(); ++a) {
      window[members[a]] = std::move(active[a]);
      keyframes[members[a]].world_from_key = window[members[a]].world_from_key;
    }
  }

  std::optional<KeyframeReason> due(const TrackResult& r) const {
    const KeyframeOptions& o = config.keyframes;
    if (o.period > 0 && frames_since_keyframe >= o.period) return KeyframeReason::kPeriod;
    const SE3& pose = r.alignment.cur_from_ref;
    if (pose.translation.norm() > o.translation || rotation_angle(pose) > o.rotation)
      return KeyframeReason::kMotion;
    if (r.overlap < o.overlap) return KeyframeReason::kOverlap;
    if (r.inlier_ratio < o.inliers) return KeyframeReason::kInliers;
    return std::nullopt;
  }
};

Odometry::Odometry(const DistortedCamera& camera, const Config& config)
    : state_(std::make_unique<State>()) {
  state_->config = config;
  state_->undistortion = make_undistortion(camera);
  if (config.edge.detector == Detector::kNetwork)
    state_->network = open_network(config.network, state_->undistortion.valid.size());
}
Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

FrameReport Odometry::process(const RgbdImage& image) {
  State& s = *state_;
  Stopwatch total, watch;
  FrameReport report{.index = s.index++, .stamp = image.stamp};
  const Frame frame = make_frame(image, s.undistortion, s.config.frame);
  report.milliseconds.frame = watch.lap();
  if (s.keyframes.empty()) {
    s.frames.push_back({image.stamp});
    s.add_keyframe(frame, SE3{}, report.milliseconds);
    report.status = FrameStatus::kFirst;
    report.keyframe = KeyframeReason::kFirst;
    report.milliseconds.total = total.lap();
    return report;
  }
  const Keyframe& key = s.keyframes.back();
  Alignment predicted = s.last;
  predicted.cur_from_ref = inverse(s.motion) * s.last.cur_from_ref;
  if (coarse_cost(key.reference, frame, s.last, s.config.tracking) <
      coarse_cost(key.reference, frame, predicted, s.config.tracking))
    predicted = s.last;
  const TrackResult result = track(key.reference, frame, predicted, s.config.tracking);
  report.milliseconds.tracking = watch.lap();
  report.levels = result.levels;
  report.overlap = result.overlap;
  report.inlier_ratio = result.inlier_ratio;
  report.rms = result.sigma;
  report.information = result.information;
  report.points = result.levels.back().points;
  ++s.frames_since_keyframe;
  const SE3 key_from_camera = inverse(result.alignment.cur_from_ref);
  s.motion = s.last.cur_from_ref * key_from_camera;
  report.world_from_camera = key.world_from_key * key_from_camera;
  report.status = FrameStatus::kTracked;
  s.frames.push_back({image.stamp, s.keyframes.size() - 1, key_from_camera});
  s.last = result.alignment;
  if (result.status == TrackStatus::kLost) {
    report.status = FrameStatus::kLost;
    s.motion = {};
  }
  if (const auto reason = s.due(result)) {
    report.keyframe = reason;
    s.add_keyframe(frame, report.world_from_camera, report.milliseconds);
  }
  report.milliseconds.total = total.lap();
  return report;
}

Trajectory Odometry::trajectory() const {
  Trajectory all;
  for (const FrameLink& link : state_->frames)
    all.push_back(
        {link.stamp, state_->keyframes[link.keyframe].world_from_key * link.key_from_camera});
  return all;
}

Trajectory Odometry::keyframes() const {
  Trajectory all;
  for (const Keyframe& key : state_->keyframes) all.push_back({key.stamp, key.world_from_key});
  return all;
}

}  // namespace edvo
