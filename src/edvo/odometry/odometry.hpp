// SPDX-License-Identifier: MIT
// The visual odometry: RGB-D images in, poses out.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/features/edge_detector.hpp"
#include "edvo/image/frame.hpp"
#include "edvo/map/keyframe.hpp"
#include "edvo/map/map.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/odometry/frame_result.hpp"

#include <memory>
#include <span>

namespace edvo {

// An image as far as it can be made ready alone: grey pyramid, corrected for the lens. Colour,
// edges and the whole depth image are made of keyframes only.
struct PreparedImage {
  Frame frame;
  double milliseconds = 0;  // that making it ready took [ms]
};

// The world frame is the camera frame of the first image that could be used.
//
// One thread at a time, except for prepare(), which any number of threads may call meanwhile. Two
// objects share nothing.
class Odometry {
 public:
  // Opens no file. detector: finds the edges of keyframes; without one, what config.edge.detector
  // names, unless that is a network, which has to be handed in (edvo::network). Throws
  // Error(kConfig, kCalibration) if the options or the camera do not fit.
  Odometry(const DistortedCamera& camera, const Config& config,
           std::unique_ptr<EdgeDetector> detector = nullptr);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  // Images must come in the order of their stamps, be of the camera's size, colour CV_8UC3 and
  // depth CV_32FC1 in metres; otherwise throws Error(kInput) and changes nothing.
  FrameResult process(const RgbdImage& image);

  // The same in two steps.
  [[nodiscard]] PreparedImage prepare(const RgbdImage& image) const;
  FrameResult process(const PreparedImage& image);

  // Refines the last keyframes to the end; finish() does that, too.
  void settle();

  // Takes over what is known from elsewhere (Slam's pose graph) about all keyframes, by id: their
  // poses, and which segments are joined to an older one. For between settle() and finish().
  void correct(std::span<const MapKeyframe> keyframes);

  // Refines the last keyframes to the end, and then all of a segment together. Call it once after
  // the last image; more images may follow. The result is the same for any number of threads.
  void finish(int threads = 2);

  // As if no image had come: same camera, options and detector.
  void reset();

  // The best present estimate of every frame with a pose: its keyframe's pose times its motion from
  // there, and a share, by time, of what the next keyframe was moved by since it was tracked. Lost
  // frames are left out, and so are restarted ones in whose segment no frame was tracked.
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] Trajectory keyframe_trajectory() const;
  [[nodiscard]] const Map& map() const;

  // The newest keyframe with its images and points, made by this call; null if there is none yet.
  // Its pose is the present one of the map.
  [[nodiscard]] KeyframePtr newest_keyframe() const;

  // The same with no colour image and black points: colour need not be undistorted.
  [[nodiscard]] KeyframePtr newest_keyframe_in_gray() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace edvo
