// SPDX-License-Identifier: MIT
// A keyframe as it leaves the odometry: an immutable value that map, loops and viewers share.
#pragma once

#include "edvo/core/se3.hpp"
#include "edvo/core/stamp.hpp"

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

namespace edvo {

struct ColoredPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // in the keyframe's camera [m]
  std::array<std::uint8_t, 3> rgb = {0, 0, 0};
};

struct Keyframe {
  std::int64_t id = 0;  // counts up from 0 over all segments
  Stamp stamp;
  int segment = 0;                   // keyframes of two segments have no known motion between them
  SE3 world_from_camera;             // when the keyframe left the odometry's window
  cv::Mat_<cv::Vec3b> bgr;           // H x W, undistorted
  cv::Mat_<float> depth;             // H x W, undistorted [m], NaN = none
  std::vector<ColoredPoint> points;  // the pixels that the odometry selected
};

using KeyframePtr = std::shared_ptr<const Keyframe>;

}  // namespace edvo
