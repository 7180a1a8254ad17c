// SPDX-License-Identifier: MIT
// A keyframe as it leaves the odometry: an immutable value that map, loops and viewers share.
#pragma once

#include "edvo/core/colored_point.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/core/stamp.hpp"

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace edvo {

struct Keyframe {
  std::int64_t id = 0;  // counts up from 0 over all segments
  Stamp stamp;
  int segment = 0;        // keyframes of two segments have no known motion between them
  SE3 world_from_camera;  // when the keyframe left the odometry's window
  // Of a rolling shutter: while the rows were read the camera moved by their product, row by row
  // (docs/adr/0013). (rho [m/s], phi [rad/s]) in its own coordinates; [s] 0 = all rows at once.
  Vector6d velocity = Vector6d::Zero();
  double readout_seconds = 0;
  cv::Mat_<cv::Vec3b> bgr;           // H x W, undistorted
  cv::Mat_<std::uint8_t> gray;       // H x W, undistorted
  cv::Mat_<float> depth;             // H x W, undistorted [m], NaN = none
  std::vector<ColoredPoint> points;  // selected pixels, in its camera
};

using KeyframePtr = std::shared_ptr<const Keyframe>;

}  // namespace edvo
