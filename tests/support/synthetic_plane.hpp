// SPDX-License-Identifier: MIT
// An analytic world: one infinite plane that carries a sum of sines, seen by a pinhole camera.
// Intensity, its gradient and depth are known in closed form, so Jacobians can be checked exactly.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/rgbd_image.hpp"
#include "edvo/core/se3.hpp"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

namespace edvo::test {

// The plane z = distance of the world.
struct SyntheticPlane {
  double distance = 2.0;  // [m]
};

inline constexpr Camera kSmallCamera{
    .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5, .width = 160, .height = 120};
inline constexpr Camera kVgaCamera{
    .fx = 525, .fy = 525, .cx = 319.5, .cy = 239.5, .width = 640, .height = 480};

namespace detail {

// amplitude * sin(kx x + ky y + phase), wave lengths of 0.25 to 1.3 m: at 2 m and 131 px focal
// length at least 16 px, smooth for bilinear interpolation.
struct Wave {
  double amplitude = 0;   // [grey levels]
  double kx = 0, ky = 0;  // [rad/m]
  double phase = 0;       // [rad]
};

inline constexpr std::array<Wave, 6> kWaves = {{{35, 5.1, 1.3, 0.3},
                                                {30, -2.2, 6.3, 1.1},
                                                {18, 9.7, -7.9, 2.0},
                                                {15, 12.1, 10.3, 0.7},
                                                {10, -19.0, 8.1, 2.9},
                                                {9, 6.5, 24.0, 1.7}}};
inline constexpr double kMeanIntensity = 128;  // [grey levels]

// Where the ray of a pixel meets the plane, and how that point moves with the pixel.
struct PlaneHit {
  Eigen::Vector3d point;     // [m], world
  double depth = 0;          // along the camera's z [m]; not positive: behind the camera
  Eigen::Vector3d d_u, d_v;  // d point / d pixel [m/px]
};

inline PlaneHit hit_plane(const SyntheticPlane& plane, const Camera& camera,
                          const SE3& world_from_camera, double u, double v) {
  const Eigen::Matrix3d R = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d ray = R * back_project(camera, u, v, 1.0);
  const double depth = (plane.distance - world_from_camera.translation.z()) / ray.z();
  const Eigen::Vector3d ray_u = R.col(0) / camera.fx;
  const Eigen::Vector3d ray_v = R.col(1) / camera.fy;
  return {.point = world_from_camera.translation + depth * ray,
          .depth = depth,
          .d_u = depth * (ray_u - ray_u.z() / ray.z() * ray),
          .d_v = depth * (ray_v - ray_v.z() / ray.z() * ray)};
}

}  // namespace detail

// What the plane looks like at its point (x, y) [m], in grey levels, always inside [0..255].
[[nodiscard]] inline double plane_intensity(double x, double y) {
  double intensity = detail::kMeanIntensity;
  for (const auto& wave : detail::kWaves)
    intensity += wave.amplitude * std::sin(wave.kx * x + wave.ky * y + wave.phase);
  return intensity;
}

// d intensity / d (x, y) [grey levels/m].
[[nodiscard]] inline Eigen::Vector2d plane_gradient(double x, double y) {
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  for (const auto& wave : detail::kWaves)
    gradient += wave.amplitude * std::cos(wave.kx * x + wave.ky * y + wave.phase) *
                Eigen::Vector2d{wave.kx, wave.ky};
  return gradient;
}

// The exact intensity [grey levels] that the camera sees at a pixel, which need not be an integer.
[[nodiscard]] inline double intensity_at(const SyntheticPlane& plane, const Camera& camera,
                                         const SE3& world_from_camera, double u, double v) {
  const auto hit = detail::hit_plane(plane, camera, world_from_camera, u, v);
  return plane_intensity(hit.point.x(), hit.point.y());
}

// The exact image gradient there [grey levels/px].
[[nodiscard]] inline Eigen::Vector2d gradient_at(const SyntheticPlane& plane, const Camera& camera,
                                                 const SE3& world_from_camera, double u, double v) {
  const auto hit = detail::hit_plane(plane, camera, world_from_camera, u, v);
  const Eigen::Vector2d gradient = plane_gradient(hit.point.x(), hit.point.y());
  return {gradient.dot(hit.d_u.head<2>()), gradient.dot(hit.d_v.head<2>())};
}

// The exact depth there [m]; not positive where the plane lies behind the camera.
[[nodiscard]] inline double depth_at(const SyntheticPlane& plane, const Camera& camera,
                                     const SE3& world_from_camera, double u, double v) {
  return detail::hit_plane(plane, camera, world_from_camera, u, v).depth;
}

// The image without quantization. [grey levels]
[[nodiscard]] inline cv::Mat_<float> render_plane_gray(const SyntheticPlane& plane,
                                                       const Camera& camera,
                                                       const SE3& world_from_camera) {
  cv::Mat_<float> gray(camera.height, camera.width);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      gray(y, x) = static_cast<float>(intensity_at(plane, camera, world_from_camera, x, y));
  return gray;
}

[[nodiscard]] inline cv::Mat_<float> render_plane_depth(const SyntheticPlane& plane,
                                                        const Camera& camera,
                                                        const SE3& world_from_camera) {
  cv::Mat_<float> depth(camera.height, camera.width);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const double z = depth_at(plane, camera, world_from_camera, x, y);
      depth(y, x) = z > 0 ? static_cast<float>(z) : std::numeric_limits<float>::quiet_NaN();
    }
  return depth;
}

// As a camera would deliver it: grey in all three channels, rounded to 8 bits; exact depth.
[[nodiscard]] inline RgbdImage render_plane(const SyntheticPlane& plane, const Camera& camera,
                                            const SE3& world_from_camera, const Stamp& stamp = {}) {
  const cv::Mat_<float> gray = render_plane_gray(plane, camera, world_from_camera);
  RgbdImage image{.stamp = stamp,
                  .bgr = cv::Mat_<cv::Vec3b>(camera.height, camera.width),
                  .depth = render_plane_depth(plane, camera, world_from_camera)};
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      image.bgr(y, x) = cv::Vec3b::all(cv::saturate_cast<uchar>(gray(y, x)));
  return image;
}

}  // namespace edvo::test
