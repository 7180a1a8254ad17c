// SPDX-License-Identifier: MIT
// The pinhole camera with Brown-Conrady distortion, and how it shrinks with the pyramid.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace edvo {

// Ideal pinhole; pixel centres are integers. fy may be negative (ICL-NUIM's y axis points up).
struct Camera {
  double fx = 0, fy = 0;      // [px]
  double cx = 0, cy = 0;      // [px]
  int width = 0, height = 0;  // [px]
};

// A camera as calibrated: pinhole and lens distortion k1 k2 p1 p2 k3 (OpenCV's order and model).
struct DistortedCamera {
  Camera pinhole;
  std::array<double, 5> distortion = {0, 0, 0, 0, 0};
};

[[nodiscard]] inline bool is_distorted(const DistortedCamera& camera) {
  for (const double k : camera.distortion)
    if (k != 0.0) return true;
  return false;
}

// x_camera [m] -> pixel [px]. The caller has checked that z > 0.
[[nodiscard]] inline Eigen::Vector2d project(const Camera& camera, const Eigen::Vector3d& point) {
  const double inverse_z = 1.0 / point.z();
  return {camera.fx * point.x() * inverse_z + camera.cx,
          camera.fy * point.y() * inverse_z + camera.cy};
}

// pixel [px], depth along z [m] -> x_camera [m].
[[nodiscard]] inline Eigen::Vector3d back_project(const Camera& camera, double u, double v,
                                                  double depth) {
  return {(u - camera.cx) / camera.fx * depth, (v - camera.cy) / camera.fy * depth, depth};
}

// The camera of an image shrunk by cv::pyrDown, whose pixel (x, y) is centred on (2x, 2y):
// c' = c / 2. (2x2 averaging would be (c + 0.5) / 2 - 0.5; mixing them costs 0.25 px at level 1.)
[[nodiscard]] inline Camera half_size(const Camera& camera) {
  return {.fx = camera.fx / 2,
          .fy = camera.fy / 2,
          .cx = camera.cx / 2,
          .cy = camera.cy / 2,
          .width = (camera.width + 1) / 2,
          .height = (camera.height + 1) / 2};
}

}  // namespace edvo
