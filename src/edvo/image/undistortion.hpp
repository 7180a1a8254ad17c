// SPDX-License-Identifier: MIT
// From the lens as it is to an ideal pinhole, once per image.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/rgbd_image.hpp"

namespace edvo {

// A precomputed map from the undistorted to the distorted image; without sources where nothing is
// distorted. All matrices are H x W.
struct Undistortion {
  Camera camera;                   // of the undistorted images: the calibrated pinhole itself
  cv::Mat_<std::int32_t> corner;   // row-major index of the upper left of the four pixels around
  cv::Mat_<std::uint8_t> right;    // how far right of it, in 1 / 32 [px]
  cv::Mat_<std::uint8_t> down;     // how far down, in 1 / 32 [px]
  cv::Mat_<std::int32_t> nearest;  // row-major index of the nearest pixel, negative = outside
  cv::Mat_<std::uint8_t> valid;    // 255 = seen by the sensor with a pixel to spare, 0 = not
};

// Throws Error(kCalibration) if the camera has no size or no focal length.
[[nodiscard]] Undistortion make_undistortion(const DistortedCamera& camera);

// Bilinear, 8-bit, one channel or three; beyond the sensor's view its border goes on.
[[nodiscard]] cv::Mat undistort_colour(const Undistortion& undistortion, const cv::Mat& image);

}  // namespace edvo
