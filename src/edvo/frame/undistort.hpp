// SPDX-License-Identifier: MIT
// From the lens as it is to an ideal pinhole, once per image.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/image.hpp"

namespace edvo {

// A precomputed map from the undistorted to the distorted image; empty where nothing is distorted.
struct Undistortion {
  Camera camera;                 // of the undistorted images: the calibrated pinhole itself
  cv::Mat map, interpolation;    // fixed point, for colour
  cv::Mat nearest;               // integer pixels, for depth
  cv::Mat_<std::uint8_t> valid;  // H x W, 255 = seen by the sensor with a pixel to spare, 0 = not
};

// Throws Error(kCalibration) if the camera has no size or no focal length.
[[nodiscard]] Undistortion make_undistortion(const DistortedCamera& camera);

// Bilinear, 8-bit, one channel or three.
[[nodiscard]] cv::Mat undistort_colour(const Undistortion& undistortion, const cv::Mat& image);

// Nearest: depth is never averaged. Outside the sensor's view NaN.
[[nodiscard]] cv::Mat_<float> undistort_depth(const Undistortion& undistortion,
                                              const cv::Mat_<float>& depth);

}  // namespace edvo
