// SPDX-License-Identifier: MIT
// What one camera measured, for building surfaces.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <opencv2/core.hpp>

namespace edvo {

struct DepthView {
  Camera camera;
  SE3 world_from_camera;
  cv::Mat_<float> depth;    // H x W, along z [m]; 0 or NaN = none
  cv::Mat_<cv::Vec3b> rgb;  // H x W, R first
};

}  // namespace edvo
