// SPDX-License-Identifier: MIT
#include "edvo/odometry/odometry.hpp"

#include "edvo/align/edge_distance.hpp"
#include "edvo/align/surface.hpp"
#include "edvo/core/error.hpp"
#include "edvo/core/inplace_vector.hpp"
#include "edvo/features/pixel_selection.hpp"
#include "edvo/odometry/edge_mask.hpp"
#include "edvo/odometry/motion_predictor.hpp"
#include "edvo/window/keyframe_window.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

namespace edvo {
namespace {

constexpr double kClearlyBetter = 0.8;  // times the sigma of another pose: prefer this one
constexpr double kInDoubt = 1.25;       // the same of a second look while two motions are in view
constexpr double kSecondTukey = 1.5;    // [sigmas]
constexpr double kTwoMotions = 0.003;   // [widths of the image] between poses: not the same motion
constexpr double kUnexpected = 0.01;    // [widths of the image] off the motion going on
constexpr double kFarAhead = 3.0;       // times its own duration, a motion tells nothing
constexpr int kReckoned = 15;           // frames that a second motion is reckoned with
constexpr double kUsualShare = 0.1;     // of a new frame in the usual sigma
constexpr double kPoorFit = 1.5;        // times the usual sigma: a blurred keyframe may be why

// The pose of a frame hangs on its keyframe's.
struct FrameLink {
  Stamp stamp;
  std::size_t keyframe = 0;
  SE3 key_from_camera;
};

class Stopwatch {
 public:
  // Time since the last lap, [ms].
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

using Guesses = InplaceVector<Alignment, kMostMotions>;  // to the keyframe, the likeliest first

std::optional<KeyframeReason> keyframe_due(const AlignResult& result, int frames_since_keyframe,
                                           const KeyframeOptions& options) {
  if (options.period > 0 && frames_since_keyframe >= options.period) return KeyframeReason::kPeriod;
  const SE3& motion = result.alignment.cur_from_ref;
  if (motion.translation.norm() > options.translation || rotation_angle(motion) > options.rotation)
    return KeyframeReason::kMotion;
  if (result.overlap < options.overlap) return KeyframeReason::kOverlap;
  if (result.inlier_ratio < options.inliers) return KeyframeReason::kInliers;
  return std::nullopt;
}

}  // namespace

struct Odometry::State {
  Config config;
  Undistortion undistortion;
  std::unique_ptr<EdgeDetector> network;  // only where the options ask for one
  KeyframeWindow map;                     // keyframes and their joint refinement
  Reference reference;                    // of the last keyframe
  MotionPredictor coarse;                 // since the last frame
  AlignScratch scratch;
  Alignment alignment;            // of the last frame to the last keyframe
  SE3 last_from_cur;              // motion of the last two frames
  double motion_time = 0;         // that it took, 0 = not known [s]
  std::vector<FrameLink> frames;  // tracked frames
  std::optional<Stamp> newest;    // of all images
  std::int64_t images = 0;
  double usual_sigma = 0;    // of tracked frames' residuals, 0 = none yet [grey levels]
  int since_keyframe = 0;    // frames
  int lost_in_a_row = 0;     // frames
  double key_sharpness = 0;  // of the last keyframe's image
  int two_motions = 0;       // frames for which to reckon with something that moves on its own

  void check_size(const RgbdImage& image) const;
  void check_order(const Stamp& stamp) const;
  Alignment moved_by(const SE3& cur_from_last) const;
  PositionPrior position_prior(const Stamp& stamp) const;
  Guesses guesses(const Frame& frame);
  AlignResult align_best(const Frame& frame, const Guesses& guesses);
  AlignResult second_look(const Frame& frame, const PositionPrior& prior, const AlignResult& first);
  bool outdone_by(const Frame& frame, const AlignResult& result) const;
  bool add_keyframe(Frame frame, const SE3& world_from_camera, FrameResult& report);
  void follow(const Frame& frame, FrameResult& report);
  void start(const Frame& frame, const SE3& world_from_camera, KeyframeReason reason,
             FrameResult& report);
};

void Odometry::State::check_size(const RgbdImage& image) const {
  const Camera& camera = undistortion.camera;
  const auto fits = [&](const cv::Mat& m) {
    return m.cols == camera.width && m.rows == camera.height;
  };
  if (!fits(image.bgr) || !fits(image.depth))
    throw Error(ErrorCode::kInput, "image " + to_string(image.stamp) + ": colour is " +
                                       size_text(image.bgr.cols, image.bgr.rows) + ", depth " +
                                       size_text(image.depth.cols, image.depth.rows) +
                                       ", but the camera is " +
                                       size_text(camera.width, camera.height));
}

void Odometry::State::check_order(const Stamp& stamp) const {
  if (newest && stamp <= *newest)
    throw Error(ErrorCode::kInput, "image " + to_string(stamp) +
                                       ": not later than the one before, " + to_string(*newest));
}

// Of a frame to the last keyframe, from its motion since the last one.
Alignment Odometry::State::moved_by(const SE3& cur_from_last) const {
  Alignment moved = alignment;
  moved.cur_from_ref = cur_from_last * alignment.cur_from_ref;
  return moved;
}

// The motion going on, as far as the camera can leave it in that time. In a fast turn images are
// blurred, and turning and moving aside look alike; else the images know far better.
PositionPrior Odometry::State::position_prior(const Stamp& stamp) const {
  if (config.coarse.acceleration == 0 || frames.empty() || motion_time <= 0) return {};
  const double gap = seconds_between(frames.back().stamp, stamp);
  if (gap > kFarAhead * motion_time) return {};
  const SE3 key_from_last = inverse(alignment.cur_from_ref);
  const Eigen::Vector3d onward =
      inverse(last_from_cur).rotation * last_from_cur.translation * (gap / motion_time);
  return {.centre = key_from_last * onward,
          .sigma = config.coarse.acceleration * gap * std::max(gap, motion_time)};
}

// Where the frame could be, by its cost to the keyframe.
Guesses Odometry::State::guesses(const Frame& frame) {
  const SE3 going_on = inverse(last_from_cur);
  const Motions motions = config.coarse.enabled ? coarse.likely(frame, going_on, config, scratch)
                                                : Motions{going_on, SE3{}};
  Guesses all;
  InplaceVector<std::pair<double, std::size_t>, kMostMotions> costs;  // and whose
  for (const SE3& motion : motions) {
    all.push_back(moved_by(motion));
    costs.push_back(
        {coarse_cost(reference, frame, all.back(), config.tracking, scratch), costs.size()});
  }
  std::sort(costs.begin(), costs.end());
  Guesses sorted;
  for (const auto& [cost, i] : costs) sorted.push_back(all[i]);
  return sorted;
}

// From the likeliest guess; from the others if that fails. Looked at again where residuals are
// large, the motion is sudden, or something else has been seen to move.
AlignResult Odometry::State::align_best(const Frame& frame, const Guesses& guesses) {
  const PositionPrior prior = position_prior(frame.stamp);
  AlignResult result;
  for (const Alignment& guess : guesses) {
    result = align(reference, frame, guess, config.tracking, scratch, prior);
    if (result.status == AlignStatus::kTracked) break;
  }
  const bool sudden =
      mean_flow(reference, config.tracking.finest_level, result.alignment.cur_from_ref,
                moved_by(inverse(last_from_cur)).cur_from_ref) > kUnexpected;
  const double limit =
      sudden ? std::min(1.0, config.coarse.second_look) : config.coarse.second_look;
  const bool suspicious = two_motions > 0 || result.sigma >= limit * usual_sigma;
  return suspicious ? second_look(frame, prior, result) : result;
}

// Something large that moves on its own is what coarse levels see best, and they follow it; soon
// after a keyframe its motion explains the image as well as the camera's does. Fine levels alone,
// from the motion going on (or from none, if that is clearly better), and deaf to what does not
// fit, find the camera's again. Once both have differed, the benefit of the doubt is the second's.
AlignResult Odometry::State::second_look(const Frame& frame, const PositionPrior& prior,
                                         const AlignResult& first) {
  AlignOptions options = config.tracking;
  options.coarsest_level = std::min(options.coarsest_level, options.finest_level + 1);
  options.loss = Loss::kTukey;
  options.loss_parameter = kSecondTukey;
  AlignResult second;
  for (const Alignment& guess : {moved_by(inverse(last_from_cur)), alignment}) {
    const AlignResult other = align(reference, frame, guess, options, scratch, prior);
    if (other.status != AlignStatus::kTracked) continue;
    if (second.status == AlignStatus::kLost || other.sigma < kClearlyBetter * second.sigma)
      second = other;
  }
  const bool differ = mean_flow(reference, options.finest_level, first.alignment.cur_from_ref,
                                second.alignment.cur_from_ref) > kTwoMotions;
  const double limit = two_motions > 0 ? kInDoubt : differ ? 1.0 : kClearlyBetter;
  two_motions = std::max(0, two_motions - 1);
  const bool better = first.status == AlignStatus::kLost || second.sigma < limit * first.sigma;
  if (second.status == AlignStatus::kLost || !better) return first;
  if (differ) two_motions = kReckoned;
  return second;
}

// A keyframe taken in motion is blurred; a sharp frame then fits badly, and worse the blur_ratio it
// is, however little it has moved: the pose may drift by centimetres while the camera stands still.
bool Odometry::State::outdone_by(const Frame& frame, const AlignResult& result) const {
  const double factor = config.keyframes.blur_ratio;
  return factor > 0 && result.sigma > kPoorFit * usual_sigma &&
         frame.sharpness > factor * key_sharpness;
}

// Edges, corners, points, window. False, and nothing changed, if too little can be tracked. Of all
// frames these alone have their depth undistorted as a whole.
bool Odometry::State::add_keyframe(Frame frame, const SE3& world_from_camera, FrameResult& report) {
  Stopwatch watch;
  frame.depth = frame.depth.undistorted();
  const cv::Mat_<std::uint8_t> edges = edge_mask(frame, undistortion, network.get(), config);
  report.milliseconds.edges = watch.lap();
  const cv::Mat_<std::uint8_t> candidates = with_corner_discs(edges, config.corners);
  report.milliseconds.corners = watch.lap();
  const std::vector<SelectedPixel> pixels =
      select_pixels(frame, candidates, undistortion.valid, config.selection);
  if (static_cast<int>(pixels.size()) < config.selection.min_points) return false;
  reference = make_reference(frame, pixels,
                             {.gradient_weight_scale = config.tracking.gradient_weight_scale,
                              .finest_level = config.tracking.finest_level,
                              .coarsest_level = config.tracking.coarsest_level},
                             std::move(reference));
  if (config.tracking.depth_weight > 0)
    reference.surface = make_surface(frame.depth, undistortion.camera, config.tracking.surface_cell,
                                     config.tracking.depth_noise, std::move(reference.surface));
  if (config.tracking.edge_distance > 0)
    reference.edge_points = edge_points(frame.edge_distance, undistortion.camera, pixels);
  report.milliseconds.selection = watch.lap();
  map.add(frame, world_from_camera, alignment,
          spread(pixels, frame.depth.cols(), config.selection.cell, config.window.points),
          config.window);
  report.milliseconds.window = watch.lap();
  report.world_from_camera = map.keyframes().back().world_from_camera;
  alignment = {};
  key_sharpness = frame.sharpness;
  since_keyframe = 0;
  return true;
}

// The first frame, or the first after tracking was given up.
void Odometry::State::start(const Frame& frame, const SE3& world_from_camera, KeyframeReason reason,
                            FrameResult& report) {
  alignment = {};
  last_from_cur = {};
  motion_time = 0;
  report.world_from_camera = world_from_camera;
  if (!add_keyframe(frame, world_from_camera, report)) return;
  report.status = reason == KeyframeReason::kFirst ? FrameStatus::kFirst : FrameStatus::kTracked;
  report.keyframe = reason;
  lost_in_a_row = 0;
  frames.push_back({frame.stamp, map.keyframes().size() - 1, SE3{}});
}

void Odometry::State::follow(const Frame& frame, FrameResult& report) {
  Stopwatch watch;
  const Guesses starts = guesses(frame);
  const AlignResult result = align_best(frame, starts);
  report.milliseconds.tracking = watch.lap();
  report.levels = result.levels;
  report.overlap = result.overlap;
  report.inlier_ratio = result.inlier_ratio;
  report.rms = result.sigma;
  report.points = result.levels.back().points;
  // Of the keyframe before this frame: what a keyframe costs is shared by the frames after it.
  map.refine(undistortion.camera, config.window);
  report.milliseconds.window = watch.lap();
  const SE3 world_from_key = map.keyframes().back().world_from_camera;
  if (result.status == AlignStatus::kLost) {
    last_from_cur = alignment.cur_from_ref * inverse(starts.front().cur_from_ref);
    motion_time = 0;
    alignment = starts.front();
    report.world_from_camera = world_from_key * inverse(alignment.cur_from_ref);
    if (++lost_in_a_row > config.keyframes.max_lost_frames)
      start(frame, report.world_from_camera, KeyframeReason::kLost, report);
    return;
  }
  const SE3 key_from_camera = inverse(result.alignment.cur_from_ref);
  last_from_cur = alignment.cur_from_ref * key_from_camera;
  motion_time = lost_in_a_row == 0 ? seconds_between(frames.back().stamp, frame.stamp) : 0;
  alignment = result.alignment;
  lost_in_a_row = 0;
  usual_sigma += (usual_sigma > 0 ? kUsualShare : 1.0) * (result.sigma - usual_sigma);
  ++since_keyframe;
  report.status = FrameStatus::kTracked;
  report.information = result.information;
  report.world_from_camera = world_from_key * key_from_camera;
  frames.push_back({frame.stamp, map.keyframes().size() - 1, key_from_camera});
  std::optional<KeyframeReason> due = keyframe_due(result, since_keyframe, config.keyframes);
  if (!due && outdone_by(frame, result)) due = KeyframeReason::kSharper;
  if (due && add_keyframe(frame, report.world_from_camera, report)) {
    report.keyframe = due;
    frames.back() = {frame.stamp, map.keyframes().size() - 1, SE3{}};
  }
}

Odometry::Odometry(const DistortedCamera& camera, const Config& config,
                   std::unique_ptr<EdgeDetector> detector)
    : state_(std::make_unique<State>()) {
  check(config);
  state_->config = config;
  state_->undistortion = make_undistortion(camera);
  state_->network = std::move(detector);
  if (config.edge.detector == Detector::kNetwork && !state_->network)
    state_->network = open_network(config.network, state_->undistortion.valid.size());
}

Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

PreparedImage Odometry::prepare(const RgbdImage& image) const {
  state_->check_size(image);
  Stopwatch watch;
  PreparedImage prepared{.frame = make_frame(image, state_->undistortion, state_->config.frame)};
  const Config& config = state_->config;
  if (config.tracking.edge_distance > 0)
    prepared.frame.edge_distance =
        make_edge_distance(canny_edges(prepared.frame.levels.front().gray, config.canny),
                           static_cast<int>(prepared.frame.levels.size()));
  prepared.milliseconds = watch.lap();
  return prepared;
}

FrameResult Odometry::process(const RgbdImage& image) {
  return process_prepared(prepare(image));
}

FrameResult Odometry::process_prepared(const PreparedImage& image) {
  State& s = *state_;
  const Frame& frame = image.frame;
  s.check_order(frame.stamp);
  s.newest = frame.stamp;
  Stopwatch total;
  FrameResult report{.index = s.images++, .stamp = frame.stamp};
  report.milliseconds.frame = image.milliseconds;
  if (s.map.keyframes().empty())
    s.start(frame, SE3{}, KeyframeReason::kFirst, report);
  else
    s.follow(frame, report);
  if (s.config.coarse.enabled) s.coarse.remember(frame, s.config);
  report.milliseconds.total = image.milliseconds + total.lap();
  return report;
}

Trajectory Odometry::trajectory() const {
  const Trajectory keyframes = this->keyframes();
  Trajectory all;
  all.reserve(state_->frames.size());
  for (const FrameLink& link : state_->frames)
    all.push_back({link.stamp, keyframes[link.keyframe].world_from_camera * link.key_from_camera});
  return all;
}

Trajectory Odometry::keyframes() const {
  KeyframeWindow map = state_->map;
  while (map.refine(state_->undistortion.camera, state_->config.window)) {
  }
  return map.keyframes();
}

}  // namespace edvo
