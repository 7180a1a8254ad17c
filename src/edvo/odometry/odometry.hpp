// SPDX-License-Identifier: MIT
// The visual odometry: RGB-D images in, poses out. The one stateful object of the library.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/features/edge_detector.hpp"
#include "edvo/image/frame.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/odometry/frame_result.hpp"

#include <memory>

namespace edvo {

// An image with all done that needs no other image.
struct PreparedImage {
  Frame frame;
  double milliseconds = 0;  // that it took [ms]
};

// The world frame is the camera frame of the first image that could be used.
class Odometry {
 public:
  // Throws Error(kConfig, kCalibration, kModel) if the options, the camera or the network's model
  // do not fit. A detector given takes the place of the network that the options name.
  Odometry(const DistortedCamera& camera, const Config& config,
           std::unique_ptr<EdgeDetector> detector = nullptr);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  // Images must come in the order of their stamps and be of the camera's size; otherwise throws
  // Error(kInput) and changes nothing.
  FrameResult process(const RgbdImage& image);

  // The same in two steps: other threads may prepare the images to come, in any order.
  [[nodiscard]] PreparedImage prepare(const RgbdImage& image) const;
  FrameResult process_prepared(const PreparedImage& image);

  // The best present estimate of every tracked frame so far: frames hang on their keyframe, so that
  // they follow when a later joint refinement moves it. Lost frames are left out.
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] Trajectory keyframes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace edvo
