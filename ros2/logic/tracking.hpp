// SPDX-License-Identifier: MIT
// What the ROS 2 node does, without ROS: pairs images by time, tracks, and says poses, covariances
// and transforms as ROS has them (REP 103, REP 105).
#pragma once

#include "edvo/odometry/config.hpp"
#include "edvo/slam/slam.hpp"
#include "logic/image_message.hpp"

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace edvo::ros {

// base_from_optical of a camera that looks along x of a base with y to the left and z up (REP 103).
[[nodiscard]] SE3 base_from_optical_rep103();

struct TrackingOptions {
  Method method = kDefaultMethod;
  double units_per_metre = 1000;  // of 16-bit depth
  double sync_tolerance = 0.02;   // between a colour image and its depth at most [s]
  int queue = 10;                 // images of each kind that wait for a partner
};

// What is published for one pair of images.
struct TrackingOutput {
  FrameResult result;
  std::int64_t stamp_ns = 0;  // of the colour image
  bool has_pose = false;      // false: lost, publish no transform
  SE3 odom_from_base;         // continuous: never jumps, but drifts
  SE3 map_from_odom;          // jumps when a place is found again or a map is saved
  // Of odom_from_base in nav_msgs/Odometry's order and axes: x y z [m], then rotations about the
  // axes of odom [rad]. It grows with the way since the first frame.
  Matrix6d covariance = Matrix6d::Zero();
};

struct TrackingStatus {
  std::int64_t tracked = 0, lost = 0;
  std::int64_t unpaired = 0;  // images without a partner
  std::int64_t refused = 0;   // pairs that could not be used, the last one because of:
  std::string last_problem;
  std::int64_t restarts = 0;  // as the clock jumped back, the last one by: [s]
  double last_jump = 0;
};

// Stamps of the images of one kind.
class StampClock {
 public:
  void add(std::int64_t stamp_ns);
  // Median of the last differences, none before there is one. [ns]
  [[nodiscard]] std::optional<std::int64_t> period() const;
  [[nodiscard]] std::optional<std::int64_t> last() const { return last_; }

 private:
  std::optional<std::int64_t> last_;
  std::deque<std::int64_t> periods_;
};

// Not synchronized: callbacks of one group.
class Tracking {
 public:
  explicit Tracking(const TrackingOptions& options);

  // The first one counts, until reset(). Throws Error(kCalibration, kConfig).
  void set_camera(const DistortedCamera& camera);
  [[nodiscard]] bool has_camera() const { return camera_.has_value(); }

  // Where the camera is mounted; before the first image. Without it as REP 103 has it.
  void set_base_from_optical(const SE3& base_from_optical) { base_from_optical_ = base_from_optical; }

  // Images of either kind in the order of their stamps. Returns something when the image completes
  // a pair and a camera is known. A pair that cannot be used is counted. Two are a pair if they are
  // nearer than sync_tolerance and than half the time between two images: else a lost image would
  // shift all pairs after it. Stamps that jump back, as when a bag is played again, begin anew with
  // the same camera.
  [[nodiscard]] std::optional<TrackingOutput> add_colour(ImageMessage image);
  [[nodiscard]] std::optional<TrackingOutput> add_depth(ImageMessage image);

  [[nodiscard]] const TrackingStatus& status() const { return status_; }

  // As if no image had come; the camera is asked for anew.
  void reset();

  // Refines what was seen and writes it, for edvo run --map; odom goes on where it was. Throws Error(kUsage) if there is
  // nothing yet, Error(kOutput) if it cannot be written.
  void save_map(const std::filesystem::path& file);

 private:
  void note_stamp(StampClock& clock, std::int64_t stamp_ns);
  void begin_anew();
  void finish_in_place();
  [[nodiscard]] bool is_pair(const ImageMessage& colour, const ImageMessage& depth) const;
  [[nodiscard]] std::optional<TrackingOutput> take_pair();
  [[nodiscard]] std::optional<TrackingOutput> track(const ImageMessage& colour,
                                                    const ImageMessage& depth);
  [[nodiscard]] TrackingOutput output_of(const FrameResult& result);
  [[nodiscard]] Matrix6d camera_covariance(const FrameResult& result);
  void drop_oldest(std::deque<ImageMessage>& images);

  TrackingOptions options_;
  Config config_;
  std::optional<DistortedCamera> camera_;
  SE3 base_from_optical_ = base_from_optical_rep103();
  std::optional<Slam> slam_;
  SE3 odom_from_world_;  // the world is moved when a map is saved, odom is not
  std::optional<FrameResult> last_tracked_;
  std::deque<ImageMessage> colours_, depths_;
  StampClock colour_clock_, depth_clock_;
  // Of xi in world_from_keyframe * exp(xi), by keyframe.
  std::map<KeyframeId, Matrix6d> keyframe_covariances_;
  TrackingStatus status_;
};

}  // namespace edvo::ros
