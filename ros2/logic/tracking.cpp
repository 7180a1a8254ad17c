// SPDX-License-Identifier: MIT
#include "logic/tracking.hpp"

#include "edvo/core/error.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/saved_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>
#include <vector>

namespace edvo::ros {
namespace {

// a * motion * inverse(a): the motion as it is in the frame that a leads to.
SE3 seen_from(const SE3& a, const SE3& motion) {
  return a * motion * inverse(a);
}

Matrix6d inverse_of(const Matrix6d& information) {
  return information.ldlt().solve(Matrix6d::Identity());
}

}  // namespace

void StampClock::add(std::int64_t stamp_ns) {
  constexpr std::size_t kRemembered = 9;
  if (last_ && stamp_ns > *last_) periods_.push_back(stamp_ns - *last_);
  if (periods_.size() > kRemembered) periods_.pop_front();
  last_ = stamp_ns;
}

std::optional<std::int64_t> StampClock::period() const {
  if (periods_.empty()) return std::nullopt;
  std::vector<std::int64_t> sorted(periods_.begin(), periods_.end());
  std::ranges::sort(sorted);
  return sorted[sorted.size() / 2];
}

SE3 base_from_optical_rep103() {
  Eigen::Matrix3d rotation;  // optical: x right, y down, z ahead
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {.rotation = Eigen::Quaterniond(rotation), .translation = Eigen::Vector3d::Zero()};
}

Tracking::Tracking(const TrackingOptions& options)
    : options_(options), config_(preset(options.method)) {
  if (!(options.units_per_metre > 0) || !(options.sync_tolerance >= 0) || options.queue < 1)
    throw Error(ErrorCode::kConfig,
                "units_per_metre must be above 0, sync_tolerance not negative, queue at least 1");
  if (!has_back_end(config_) || config_.edge.detector == Detector::kNetwork)
    throw Error(ErrorCode::kConfig, "method " + std::string(name_of(options.method)) +
                                        ": the node runs canny+corner only");
}

void Tracking::set_camera(const DistortedCamera& camera) {
  if (camera_) return;
  slam_.emplace(camera, config_);
  camera_ = camera;
}

std::optional<TrackingOutput> Tracking::add_colour(ImageMessage image) {
  note_stamp(colour_clock_, image.stamp_ns);
  colours_.push_back(std::move(image));
  drop_oldest(colours_);
  return take_pair();
}

std::optional<TrackingOutput> Tracking::add_depth(ImageMessage image) {
  note_stamp(depth_clock_, image.stamp_ns);
  depths_.push_back(std::move(image));
  drop_oldest(depths_);
  return take_pair();
}

// Messages may overtake each other a little; more than that is another time.
void Tracking::note_stamp(StampClock& clock, std::int64_t stamp_ns) {
  constexpr std::int64_t kJump = 1'000'000'000;  // [ns]
  const auto last = clock.last();
  if (last && stamp_ns < *last - kJump) {
    begin_anew();
    ++status_.restarts;
    status_.last_jump = 1e-9 * static_cast<double>(*last - stamp_ns);
  }
  clock.add(stamp_ns);
}

void Tracking::begin_anew() {
  if (camera_) slam_.emplace(*camera_, config_);
  odom_from_world_ = {};
  last_tracked_.reset();
  colours_.clear();
  depths_.clear();
  colour_clock_ = depth_clock_ = {};
  keyframe_covariances_.clear();
}

void Tracking::drop_oldest(std::deque<ImageMessage>& images) {
  if (images.size() <= static_cast<std::size_t>(options_.queue)) return;
  images.pop_front();
  ++status_.unpaired;
}

// While no period is known, a depth image before the colour image might be that of another one.
bool Tracking::is_pair(const ImageMessage& colour, const ImageMessage& depth) const {
  const std::int64_t difference = std::abs(depth.stamp_ns - colour.stamp_ns);
  if (difference > static_cast<std::int64_t>(1e9 * options_.sync_tolerance)) return false;
  const auto of_colour = colour_clock_.period(), of_depth = depth_clock_.period();
  if (!of_colour && !of_depth) return depth.stamp_ns >= colour.stamp_ns;
  constexpr std::int64_t kUnknown = std::numeric_limits<std::int64_t>::max();
  return 2 * difference < std::min(of_colour.value_or(kUnknown), of_depth.value_or(kUnknown));
}

// The first two that are near in time; what is older than them finds no partner any more.
std::optional<TrackingOutput> Tracking::take_pair() {
  for (std::size_t c = 0; c < colours_.size(); ++c) {
    const std::int64_t stamp = colours_[c].stamp_ns;
    const auto nearest = std::ranges::min_element(depths_, {}, [&](const ImageMessage& depth) {
      return std::abs(depth.stamp_ns - stamp);
    });
    if (nearest == depths_.end() || !is_pair(colours_[c], *nearest)) continue;
    const ImageMessage colour = std::move(colours_[c]);
    const ImageMessage depth = std::move(*nearest);
    status_.unpaired += static_cast<std::int64_t>(c) + (nearest - depths_.begin());
    colours_.erase(colours_.begin(), colours_.begin() + static_cast<std::ptrdiff_t>(c) + 1);
    depths_.erase(depths_.begin(), nearest + 1);
    return track(colour, depth);
  }
  return std::nullopt;
}

std::optional<TrackingOutput> Tracking::track(const ImageMessage& colour,
                                              const ImageMessage& depth) {
  if (!slam_) return std::nullopt;  // no CameraInfo yet
  try {
    const FrameResult result =
        slam_->process({.stamp = {.nanoseconds = colour.stamp_ns, .decimals = 9},
                        .bgr = to_bgr(colour),
                        .depth = to_metres(depth, options_.units_per_metre)});
    return output_of(result);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInput) throw;
    ++status_.refused;
    status_.last_problem = error.what();
    return std::nullopt;
  }
}

TrackingOutput Tracking::output_of(const FrameResult& result) {
  TrackingOutput output{.result = result, .stamp_ns = result.stamp.nanoseconds};
  output.has_pose = is_tracked(result.status);
  ++(output.has_pose ? status_.tracked : status_.lost);
  output.odom_from_base =
      seen_from(base_from_optical_, odom_from_world_ * result.world_from_camera);
  output.map_from_odom =
      seen_from(base_from_optical_, slam_->map_frame(result.segment).map_from_odometry *
                                        inverse(odom_from_world_));
  if (!output.has_pose) return output;
  last_tracked_ = result;

  const Matrix6d to_base = adjoint(base_from_optical_);
  const Matrix6d in_base = to_base * camera_covariance(result) * to_base.transpose();
  Matrix6d to_odom = Matrix6d::Zero();
  const Eigen::Matrix3d rotation = output.odom_from_base.rotation.toRotationMatrix();
  to_odom.topLeftCorner<3, 3>() = to_odom.bottomRightCorner<3, 3>() = rotation;
  output.covariance = to_odom * in_base * to_odom.transpose();
  return output;
}

// Of xi in world_from_camera * exp(xi): the keyframe's, carried over to the camera, and the frame's
// own.
Matrix6d Tracking::camera_covariance(const FrameResult& result) {
  Matrix6d covariance = inverse_of(result.information);
  if (const auto keyframe = keyframe_covariances_.find(result.keyframe);
      keyframe != keyframe_covariances_.end()) {
    const Matrix6d carry = adjoint(inverse(result.keyframe_from_camera));
    covariance += carry * keyframe->second * carry.transpose();
  }
  if (result.new_keyframe) keyframe_covariances_[*result.new_keyframe] = covariance;
  return covariance;
}

void Tracking::reset() {
  camera_.reset();
  slam_.reset();
  begin_anew();
  status_ = {};
}

// Moves the world, in which frames after this one are found, and odom_from_world against it.
void Tracking::finish_in_place() {
  slam_->finish();
  if (!last_tracked_) return;
  const Trajectory trajectory = slam_->trajectory();
  const auto moved = std::ranges::find(trajectory, last_tracked_->stamp, &StampedPose::stamp);
  if (moved == trajectory.end()) return;
  odom_from_world_ =
      odom_from_world_ * last_tracked_->world_from_camera * inverse(moved->world_from_camera);
  last_tracked_->world_from_camera = moved->world_from_camera;
}

void Tracking::save_map(const std::filesystem::path& file) {
  if (!slam_ || slam_->map().keyframes().empty())
    throw Error(ErrorCode::kUsage, file.string() + ": nothing was seen yet that could be saved");
  finish_in_place();
  edvo::save_map(file, make_saved_map(*slam_, {.camera = camera_->pinhole,
                                               .depth_scale = options_.units_per_metre,
                                               .method = std::string(name_of(options_.method)),
                                               .config = to_toml(config_),
                                               .made_by = "edvo's ROS 2 node"}));
}

}  // namespace edvo::ros
