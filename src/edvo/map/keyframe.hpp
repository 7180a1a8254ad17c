// SPDX-License-Identifier: MIT
// A keyframe as it leaves the odometry: an immutable value that map, loops and viewers share.
#pragma once

#include "edvo/core/colored_point.hpp"
#include "edvo/core/rolling_shutter.hpp"
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
  RollingShutter shutter;
  cv::Mat_<cv::Vec3b> bgr;           // H x W, undistorted
  cv::Mat_<std::uint8_t> gray;       // H x W, undistorted
  cv::Mat_<float> depth;             // H x W, undistorted [m], NaN = none
  std::vector<ColoredPoint> points;  // selected pixels, in its camera
};

using KeyframePtr = std::shared_ptr<const Keyframe>;

}  // namespace edvo
