// SPDX-License-Identifier: MIT
#include "edvo/core/camera.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

constexpr std::size_t kPlumbBob = 5, kEquidistant = 4;  // number of coefficients

bool is_rational(const DistortedCamera& camera) {
  return std::any_of(camera.distortion.begin() + kPlumbBob, camera.distortion.end(),
                     [](double k) { return k != 0; });
}

Eigen::Vector2d distort_polynomial(const std::array<double, 8>& k, double x, double y) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = k;
  const double r2 = x * x + y * y;
  const double radial =
      (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

Eigen::Vector2d distort_equidistant(const std::array<double, 8>& k, double x, double y) {
  constexpr double kOnAxis = 1e-12;  // where angle and tangent are the same number
  const double tangent = std::hypot(x, y);
  if (tangent < kOnAxis) return {x, y};
  const double angle = std::atan(tangent), a2 = angle * angle;
  const double bent = angle * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
  return {x * bent / tangent, y * bent / tangent};
}

// Most lenses are nearly a pinhole; an equidistant one is up to its coefficients the angle.
Eigen::Vector2d first_guess(const DistortedCamera& camera, const Eigen::Vector2d& distorted) {
  constexpr double kWidest = 1.5;  // [rad] from the axis
  const double angle = distorted.norm();
  if (camera.lens != LensModel::kEquidistant || angle == 0) return distorted;
  return distorted / angle * std::tan(std::min(angle, kWidest));
}

}  // namespace

bool is_distorted(const DistortedCamera& camera) {
  return camera.lens == LensModel::kEquidistant ||
         std::ranges::any_of(camera.distortion, [](double k) { return k != 0; });
}

std::string_view distortion_model(const DistortedCamera& camera) {
  if (camera.lens == LensModel::kEquidistant) return "equidistant";
  return is_rational(camera) ? "rational_polynomial" : "plumb_bob";
}

std::span<const double> distortion_coefficients(const DistortedCamera& camera) {
  const std::span<const double> all = camera.distortion;
  if (camera.lens == LensModel::kEquidistant) return all.first(kEquidistant);
  return is_rational(camera) ? all : all.first(kPlumbBob);
}

Eigen::Vector2d distort(const DistortedCamera& camera, const Eigen::Vector2d& ray) {
  return camera.lens == LensModel::kEquidistant
             ? distort_equidistant(camera.distortion, ray.x(), ray.y())
             : distort_polynomial(camera.distortion, ray.x(), ray.y());
}

Eigen::Vector2d undistort(const DistortedCamera& camera, const Eigen::Vector2d& distorted) {
  constexpr int kSteps = 12;
  constexpr double kDelta = 1e-6;
  Eigen::Vector2d ray = first_guess(camera, distorted);
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector2d error = distort(camera, ray) - distorted;
    if (error.norm() < 1e-12) break;
    Eigen::Matrix2d J;
    J.col(0) = (distort(camera, ray + Eigen::Vector2d{kDelta, 0}) -
                distort(camera, ray - Eigen::Vector2d{kDelta, 0})) /
               (2 * kDelta);
    J.col(1) = (distort(camera, ray + Eigen::Vector2d{0, kDelta}) -
                distort(camera, ray - Eigen::Vector2d{0, kDelta})) /
               (2 * kDelta);
    ray -= J.inverse() * error;
  }
  return ray;
}

}  // namespace edvo
