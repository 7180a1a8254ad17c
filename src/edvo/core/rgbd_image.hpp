// SPDX-License-Identifier: MIT
// What a camera delivers: one colour image and one registered depth image.
#pragma once

#include "edvo/core/stamp.hpp"

#include <opencv2/core.hpp>

namespace edvo {

// As read from the sensor, not undistorted.
struct RgbdImage {
  Stamp stamp;              // of the colour image
  cv::Mat_<cv::Vec3b> bgr;  // H x W, OpenCV's channel order
  cv::Mat_<float> depth;    // H x W, [m], NaN = none
};

}  // namespace edvo
