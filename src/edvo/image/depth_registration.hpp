// SPDX-License-Identifier: MIT
// Depth of a sensor beside the colour camera, as the colour camera would have measured it.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <opencv2/core.hpp>

namespace edvo {

// Computed once for a pair of cameras.
struct DepthRegistration {
  DistortedCamera depth, colour;
  // H x W of the depth image: direction of each pixel of 1 m along z of the depth camera, turned
  // into the colour camera.
  cv::Mat_<float> ray_x, ray_y, ray_z;
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();  // of the depth camera in the colour camera [m]
  float largest_radius = 0;  // squared, of points in the colour camera's view; z = 1
};

// colour_from_depth: points of the depth camera [m] into the colour camera. Throws
// Error(kCalibration) if a camera has no size or no focal length.
[[nodiscard]] DepthRegistration make_depth_registration(const DistortedCamera& depth,
                                                        const DistortedCamera& colour,
                                                        const SE3& colour_from_depth);

// depth: H x W of the depth camera, [m], NaN = none. Returns the depth along z of the colour camera
// at each pixel of its (distorted) image, NaN where the depth camera sees nothing or another
// surface hides what it sees. A depth pixel covers the area up to its neighbours, and within it the
// surface goes on as a plane, so that neither a finer colour image nor a slanted surface leaves
// holes. Throws Error(kInput) if the image is not of the depth camera's size.
[[nodiscard]] cv::Mat_<float> register_depth(const DepthRegistration& registration,
                                             const cv::Mat_<float>& depth);

}  // namespace edvo
