// SPDX-License-Identifier: MIT
// Rigid motions in 3-D. Conventions (names, update rule, order of xi) are in docs/conventions.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace edvo {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A rigid motion, named target_from_source: x_target = target_from_source * x_source.
struct SE3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // unit length
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         // [m]
};

[[nodiscard]] inline SE3 operator*(const SE3& a, const SE3& b) {
  return {.rotation = (a.rotation * b.rotation).normalized(),
          .translation = a.rotation * b.translation + a.translation};
}

[[nodiscard]] inline Eigen::Vector3d operator*(const SE3& a, const Eigen::Vector3d& point) {
  return a.rotation * point + a.translation;
}

[[nodiscard]] inline SE3 inverse(const SE3& a) {
  const Eigen::Quaterniond rotation = a.rotation.conjugate();
  return {.rotation = rotation, .translation = -(rotation * a.translation)};
}

// The skew-symmetric matrix of v: hat(v) * w is the cross product of v and w.
[[nodiscard]] Eigen::Matrix3d hat(const Eigen::Vector3d& v);

// The exponential map of SE(3); xi = (rho [m], phi [rad]). Accurate also near zero.
[[nodiscard]] SE3 exp(const Vector6d& xi);

// The inverse of exp; the rotation angle of the result lies in [0, pi].
[[nodiscard]] Vector6d log(const SE3& a);

// Ad(a), so that a * exp(xi) * inverse(a) = exp(Ad(a) xi).
[[nodiscard]] Matrix6d adjoint(const SE3& a);

[[nodiscard]] bool is_finite(const SE3& a);

// Angle of the rotation, [rad] in [0, pi].
[[nodiscard]] double rotation_angle(const SE3& a);

}  // namespace edvo
