// SPDX-License-Identifier: MIT
// The pinhole camera, how its lens distorts, and how it shrinks with the pyramid.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>

namespace edvo {

// Ideal pinhole; pixel centres are integers. fy may be negative (ICL-NUIM's y axis points up).
struct Camera {
  double fx = 0, fy = 0;      // [px]
  double cx = 0, cy = 0;      // [px]
  int width = 0, height = 0;  // [px]
};

// Formulas and order of the coefficients are OpenCV's.
enum class LensModel {
  kPolynomial,   // k1 k2 p1 p2 k3 (Brown 1966), rational with k4 k5 k6
  kEquidistant,  // k1 k2 k3 k4 of the angle to the axis (Kannala and Brandt 2006): OpenCV's fisheye
};

// A camera as calibrated: pinhole and lens.
struct DistortedCamera {
  Camera pinhole;
  std::array<double, 8> distortion = {};  // of which kEquidistant has the first four
  LensModel lens = LensModel::kPolynomial;
};

// An equidistant lens is no pinhole even if all its coefficients are zero.
[[nodiscard]] bool is_distorted(const DistortedCamera& camera);

// The lens model by the name that ROS has for it: plumb_bob, rational_polynomial or equidistant.
[[nodiscard]] std::string_view distortion_model(const DistortedCamera& camera);

// The coefficients of that model: 5, 8 or 4.
[[nodiscard]] std::span<const double> distortion_coefficients(const DistortedCamera& camera);

// ray: (x / z, y / z) of a point in the camera's frame. Returns the distorted normalized
// coordinates: its pixel in the distorted image is (fx * x + cx, fy * y + cy).
[[nodiscard]] Eigen::Vector2d distort(const DistortedCamera& camera, const Eigen::Vector2d& ray);

// The inverse of distort(), by Newton's method with numeric derivatives. Both in normalized
// coordinates.
[[nodiscard]] Eigen::Vector2d undistort(const DistortedCamera& camera,
                                        const Eigen::Vector2d& distorted);

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
