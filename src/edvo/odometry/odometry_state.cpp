// SPDX-License-Identifier: MIT
#include "edvo/odometry/odometry_state.hpp"

#include "edvo/align/surface.hpp"
#include "edvo/core/error.hpp"
#include "edvo/features/corners.hpp"
#include "edvo/odometry/loss_test.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace edvo {
namespace {

constexpr std::int64_t kEstablished = 5;  // tracked frames that make a segment worth coming back to
constexpr int kMostUndecided = 15;        // frames lost to a second motion: it may pass
constexpr int kMostHidden = 60;           // the same, where something hides what was seen before
constexpr double kEntered = 0.1;          // [0..1] that it hid at the last good frame

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

Odometry::State::State(const Config& options, Undistortion map_of_pixels)
    : config((check(options), options)),
      undistortion(std::move(map_of_pixels)),
      policy(options.keyframes),
      guard(options.tracking) {}

void Odometry::State::require_newer(const Stamp& stamp) {
  if (newest_stamp && stamp <= *newest_stamp)
    throw Error(ErrorCode::kInput, "image " + to_string(stamp) +
                                       ": not later than the one before, " +
                                       to_string(*newest_stamp));
  newest_stamp = stamp;
}

bool Odometry::State::has_tracked(int segment_id) const {
  return std::binary_search(tracked_segments.begin(), tracked_segments.end(), segment_id);
}

bool Odometry::State::begin_segment(const Frame& frame, KeyframeReason reason,
                                    FrameResult& result) {
  Segment fresh{.id = segments};
  fresh.state.usual_sigma = segment.state.usual_sigma;
  fresh.state.low_sigma = segment.state.low_sigma;
  const SE3 last_good = segment.keyframe < 0 ? SE3{}
                                             : map[segment.keyframe].world_from_camera *
                                                   inverse(segment.state.alignment.cur_from_ref);
  if (!insert_into(fresh, frame, last_good, result)) {
    result.loss_cause = image_fault(frame, config.selection);
    if (result.loss_cause == LossCause::kNone) result.loss_cause = LossCause::kFewPoints;
    result.world_from_camera = last_good;
    return false;
  }
  if (segment.tracked >= kEstablished) {
    if (left_segment) archive_segment(std::move(*left_segment));
    left_segment = std::move(segment);
  } else {
    archive_segment(std::move(segment));
  }
  segment = std::move(fresh);
  ++segments;
  lost_in_a_row = 0;
  const bool first = reason == KeyframeReason::kFirst;
  result.status = first ? FrameStatus::kFirst : FrameStatus::kRestarted;
  result.segment = segment.id;
  result.keyframe = segment.keyframe;
  result.new_keyframe = segment.keyframe;
  result.keyframe_reason = reason;
  result.keyframe_from_camera = {};
  result.information = kExactInformation * Matrix6d::Identity();
  result.world_from_camera = last_good;
  result.loss_cause = LossCause::kNone;
  if (first) tracked_segments.push_back(segment.id);
  links.push_back({.stamp = frame.stamp, .keyframe = segment.keyframe, .is_guess = !first});
  segment.predictor.update(frame, config);
  return true;
}

bool Odometry::State::relocalize(Frame& frame, SegmentAlignment& alignment) {
  if (!left_segment) return false;
  SegmentAlignment other = align_in(*left_segment, frame, config, guard, scratch);
  if (other.loss != LossCause::kNone) return false;
  if (segment.tracked >= kEstablished) {
    std::swap(segment, *left_segment);
  } else {
    archive_segment(std::move(segment));
    segment = *std::exchange(left_segment, std::nullopt);
  }
  alignment = std::move(other);
  return true;
}

// Poses found with it are wrong, and so is what older keyframes say: none is asked any more.
void Odometry::State::leave_out_own(const Frame& frame) {
  if (!ego.observe(frame)) return;
  CellStates own{};
  for (std::size_t cell = 0; cell < kCells; ++cell)
    if (ego.cells()[cell]) own[cell] = CellState::kUnexplained;
  segment.reference = points_outside(segment.reference, own, CellState::kUnexplained);
  segment.witness.reset();
  left_segment.reset();
}

bool Odometry::State::refine_window() {
  const bool more = segment.window.refine(undistortion.camera, readout.seconds(), config.window);
  for (const auto& [id, world_from_camera] : segment.window.refined())
    map.set_pose(id, world_from_camera);
  return more;
}

// What a frame's alignment is wrong by grows with the distance from the keyframe. Where it has
// become the next keyframe it is known, as the refinement has both; before that, about in
// proportion to time.
SE3 Odometry::State::world_from_camera(const FrameLink& link) const {
  const MapKeyframe& key = map[link.keyframe];
  const SE3 as_tracked = key.world_from_camera * link.keyframe_from_camera;
  const Successor& successor = successors[static_cast<std::size_t>(link.keyframe)];
  if (successor.id < 0) return as_tracked;
  const MapKeyframe& next = map[successor.id];
  const double share =
      seconds_between(key.stamp, link.stamp) / seconds_between(key.stamp, next.stamp);
  const SE3 refined = inverse(key.world_from_camera) * next.world_from_camera;
  return as_tracked *
         exp(std::clamp(share, 0.0, 1.0) * log(inverse(successor.keyframe_from_this) * refined));
}

void Odometry::State::record_tracked(const Frame& frame, const AlignResult& alignment,
                                     bool relocalized, FrameResult& result) {
  // What moves on its own shears the image, too.
  if (config.tracking.rolling_shutter && expects_one_motion(segment.state) && !relocalized)
    readout.observe(
        readout_evidence(segment.reference, frame, alignment, config.tracking, scratch));
  lost_in_a_row = 0;
  if (!has_tracked(segment.id))
    tracked_segments.insert(std::ranges::upper_bound(tracked_segments, segment.id), segment.id);
  result.status = relocalized ? FrameStatus::kRelocalized : FrameStatus::kTracked;
  result.segment = segment.id;
  result.keyframe = segment.keyframe;
  result.keyframe_from_camera = inverse(alignment.alignment.cur_from_ref);
  result.information = alignment.information;
  result.world_from_camera = map[segment.keyframe].world_from_camera * result.keyframe_from_camera;
  links.push_back({.stamp = frame.stamp,
                   .keyframe = segment.keyframe,
                   .keyframe_from_camera = result.keyframe_from_camera});
}

bool Odometry::State::is_view_hidden(const Frame& frame) {
  const TrackingState& state = segment.state;
  if (state.in_front < kEntered) return false;
  const SE3& last = state.alignment.cur_from_ref;
  const auto hides = [&](const Reference& reference, const SE3& cur_from_ref) {
    return is_hidden(reference, frame, cur_from_ref, config.tracking, scratch);
  };
  const std::optional<Witness>& witness = segment.witness;
  return hides(segment.reference, last) ||
         (witness && hides(witness->reference, last * witness->alignment.cur_from_ref));
}

void Odometry::State::lose_or_restart(const Frame& frame, LossCause cause, FrameResult& result) {
  const bool hidden = is_view_hidden(frame);
  if (cause == LossCause::kTwoMotions || hidden) ++segment.undecided_frames;
  const int waiting = std::min(segment.undecided_frames, hidden ? kMostHidden : kMostUndecided);
  if (++lost_in_a_row - waiting > config.keyframes.max_lost_frames &&
      begin_segment(frame, KeyframeReason::kRestart, result))
    return;
  result.loss_cause = cause;
  result.segment = segment.id;
  result.keyframe = segment.keyframe;
  result.keyframe_from_camera = inverse(segment.state.alignment.cur_from_ref);
  result.world_from_camera = map[segment.keyframe].world_from_camera * result.keyframe_from_camera;
}

bool Odometry::State::insert_keyframe(const Frame& frame, KeyframeReason reason,
                                      FrameResult& result) {
  const KeyframeId before = segment.keyframe;
  if (!insert_into(segment, frame, result.world_from_camera, result)) return false;
  successors[static_cast<std::size_t>(before)] = {
      .id = segment.keyframe, .keyframe_from_this = links.back().keyframe_from_camera};
  result.new_keyframe = segment.keyframe;
  result.keyframe_reason = reason;
  links.back() = {.stamp = frame.stamp, .keyframe = segment.keyframe};
  return true;
}

// Only keyframes have their whole depth image undistorted; other frames undistort depth where it is
// read. target stays unchanged until it is certain that the keyframe can be made.
bool Odometry::State::insert_into(Segment& target, const Frame& original,
                                  const SE3& world_from_camera, FrameResult& result) {
  Stopwatch watch;
  Frame frame = original;
  frame.depth =
      without_cells(without_cells(frame.depth.undistorted(), ego.cells()), target.state.others);
  const cv::Mat_<std::uint8_t> edges =
      detector->detect({.gray = frame.levels.front().gray,
                        .colour = [&] { return undistort_colour(undistortion, frame.bgr); }});
  result.milliseconds.edges = watch.lap();
  const cv::Mat_<std::uint8_t> candidates = with_corner_discs(edges, config.corners);
  result.milliseconds.corners = watch.lap();
  std::vector<SelectedPixel> pixels =
      select_pixels(frame, candidates, undistortion.valid, config.selection);
  if (static_cast<int>(pixels.size()) < config.selection.min_points) return false;
  if (target.keyframe >= 0)
    hand_over(target.witness, target.reference, original, target.state, config.tracking, scratch);
  target.reference = make_reference(frame, pixels,
                                    {.gradient_weight_scale = config.tracking.gradient_weight_scale,
                                     .finest_level = config.tracking.finest_level,
                                     .coarsest_level = config.tracking.coarsest_level},
                                    std::move(target.reference));
  if (config.tracking.depth_weight > 0)
    target.reference.surface =
        make_surface(frame.depth, undistortion.camera, config.tracking.surface_cell,
                     config.tracking.depth_noise, std::move(target.reference.surface));
  result.milliseconds.selection = watch.lap();
  target.corners = KeyframeCorners(frame);
  target.keyframe = map.add(frame.stamp, target.id, world_from_camera);
  successors.emplace_back();
  target.window.add(target.keyframe, frame, world_from_camera, target.state.alignment,
                    spread(pixels, frame.depth.cols(), config.selection.cell, config.window.points),
                    config.window);
  result.milliseconds.window += watch.lap();

  target.state.stamp = frame.stamp;
  target.state.alignment = {};
  target.state.keyframe_sharpness = frame.sharpness;
  target.state.frames_since_keyframe = 0;
  target.state.keyframe_sigma = 0;
  keyframe_frame = std::move(frame);
  keyframe_pixels = std::move(pixels);
  return true;
}

KeyframePtr Odometry::State::newest_keyframe(bool with_colour) const {
  if (map.keyframes().empty()) return nullptr;
  const MapKeyframe& key = map.keyframes().back();
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->id = key.id;
  keyframe->stamp = key.stamp;
  keyframe->segment = key.segment;
  keyframe->world_from_camera = key.world_from_camera;
  keyframe->shutter = keyframe_frame.shutter;
  keyframe->gray = keyframe_frame.levels.front().gray;
  if (with_colour) keyframe->bgr = undistort_colour(undistortion, keyframe_frame.bgr);
  keyframe->depth = keyframe_frame.depth.undistorted();
  keyframe->points.reserve(keyframe_pixels.size());
  for (const SelectedPixel& p : keyframe_pixels) {
    const cv::Vec3b bgr = with_colour ? keyframe->bgr(p.pixel) : cv::Vec3b::all(0);
    keyframe->points.push_back({.position = back_project(undistortion.camera, p.pixel.x, p.pixel.y,
                                                         static_cast<double>(p.depth))
                                                .cast<float>(),
                                .rgb = {bgr[2], bgr[1], bgr[0]}});
  }
  return keyframe;
}

void require_fitting(const RgbdImage& image, const Camera& camera) {
  const std::string name = "image " + to_string(image.stamp);
  if (image.bgr.type() != CV_8UC3)
    throw Error(ErrorCode::kInput, name + ": colour has the type " +
                                       cv::typeToString(image.bgr.type()) +
                                       ", but CV_8UC3 (BGR, 8 bits) is expected");
  if (image.depth.type() != CV_32FC1)
    throw Error(ErrorCode::kInput, name + ": depth has the type " +
                                       cv::typeToString(image.depth.type()) +
                                       ", but CV_32FC1 in metres is expected; divide by the depth "
                                       "scale first");
  const auto fits = [&](const cv::Mat& m) {
    return m.cols == camera.width && m.rows == camera.height;
  };
  if (!fits(image.bgr) || !fits(image.depth))
    throw Error(ErrorCode::kInput,
                name + ": colour is " + size_text(image.bgr.cols, image.bgr.rows) + ", depth " +
                    size_text(image.depth.cols, image.depth.rows) + ", but the camera is " +
                    size_text(camera.width, camera.height));
}

int level_count(const Config& config) {
  return std::max(kUsualLevels, config.tracking.coarsest_level + 1);
}

std::unique_ptr<EdgeDetector> make_detector(const Config& config) {
  switch (config.edge.detector) {
    case Detector::kCanny:
      return make_canny_detector(config.canny);
    case Detector::kNone:
      return make_dense_detector();
    case Detector::kNetwork:
      break;
  }
  throw Error(ErrorCode::kConfig,
              "edge.detector = \"network\": a network has to be handed in as an EdgeDetector "
              "(edvo/network/edge_network.hpp opens one)");
}

void describe(const AlignResult& alignment, FrameResult& result) {
  result.levels = alignment.levels;
  result.overlap = alignment.overlap;
  result.inlier_ratio = alignment.inlier_ratio;
  result.correlation = alignment.correlation;
  result.rms = alignment.sigma;
  result.points = alignment.levels.empty() ? 0 : alignment.levels.back().points;
}

}  // namespace edvo
