// SPDX-License-Identifier: MIT
#include "logic/tracking.hpp"

#include "edvo/core/error.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/saved_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

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
  colours_.push_back(std::move(image));
  drop_oldest(colours_);
  return take_pair();
}

std::optional<TrackingOutput> Tracking::add_depth(ImageMessage image) {
  depths_.push_back(std::move(image));
  drop_oldest(depths_);
  return take_pair();
}

void Tracking::drop_oldest(std::deque<ImageMessage>& images) {
  if (images.size() <= static_cast<std::size_t>(options_.queue)) return;
  images.pop_front();
  ++status_.unpaired;
}

// The first two that are near in time; what is older than them finds no partner any more.
std::optional<TrackingOutput> Tracking::take_pair() {
  const auto tolerance = static_cast<std::int64_t>(1e9 * options_.sync_tolerance);
  for (std::size_t c = 0; c < colours_.size(); ++c) {
    const std::int64_t stamp = colours_[c].stamp_ns;
    const auto nearest = std::ranges::min_element(depths_, {}, [&](const ImageMessage& depth) {
      return std::abs(depth.stamp_ns - stamp);
    });
    if (nearest == depths_.end() || std::abs(nearest->stamp_ns - stamp) > tolerance) continue;
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
  output.odom_from_base = seen_from(base_from_optical_, result.world_from_camera);
  output.map_from_odom =
      seen_from(base_from_optical_, slam_->map_frame(result.segment).map_from_odometry);
  if (!output.has_pose) return output;

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
  colours_.clear();
  depths_.clear();
  keyframe_covariances_.clear();
  status_ = {};
}

void Tracking::save_map(const std::filesystem::path& file) {
  if (!slam_ || slam_->map().keyframes().empty())
    throw Error(ErrorCode::kUsage, file.string() + ": nothing was seen yet that could be saved");
  slam_->finish();
  edvo::save_map(file, make_saved_map(*slam_, {.camera = camera_->pinhole,
                                               .depth_scale = options_.units_per_metre,
                                               .method = std::string(name_of(options_.method)),
                                               .config = to_toml(config_),
                                               .made_by = "edvo's ROS 2 node"}));
}

}  // namespace edvo::ros
