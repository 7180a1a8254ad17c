// SPDX-License-Identifier: MIT
#include "edvo/core/se3.hpp"

#include <cmath>

namespace edvo {
namespace {

// Below this angle the closed forms lose digits to cancellation and their series are exact to
// double.
constexpr double kSmallAngle = 1e-4;

// V of exp: translation = V * rho (Barfoot, State Estimation for Robotics, eq. 7.37b).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  if (angle < kSmallAngle) return Eigen::Matrix3d::Identity() + 0.5 * W + W * W / 6.0;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() + (1.0 - std::cos(angle)) / a2 * W +
         (angle - std::sin(angle)) / (a2 * angle) * W * W;
}

Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const Eigen::Matrix3d W = hat(phi);
  if (angle < kSmallAngle) return Eigen::Matrix3d::Identity() - 0.5 * W + W * W / 12.0;
  const double half = 0.5 * angle;
  const double c = (1.0 - half * std::cos(half) / std::sin(half)) / (angle * angle);
  return Eigen::Matrix3d::Identity() - 0.5 * W + c * W * W;
}

Eigen::Vector3d rotation_vector(Eigen::Quaterniond q) {
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();  // q and -q are one rotation: take the short way
  const double sine = q.vec().norm();
  if (sine < kSmallAngle)
    return 2.0 / q.w() * q.vec() * (1.0 - sine * sine / (3.0 * q.w() * q.w()));
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

SE3 exp(const Vector6d& xi) {
  const Eigen::Vector3d rho = xi.head<3>();
  const Eigen::Vector3d phi = xi.tail<3>();
  const double angle = phi.norm();
  const double half = 0.5 * angle;
  const double scale = angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(half);
  rotation.vec() = scale * phi;
  return {.rotation = rotation.normalized(), .translation = left_jacobian(phi) * rho};
}

Vector6d log(const SE3& a) {
  const Eigen::Vector3d phi = rotation_vector(a.rotation);
  Vector6d xi;
  xi.head<3>() = left_jacobian_inverse(phi) * a.translation;
  xi.tail<3>() = phi;
  return xi;
}

Matrix6d adjoint(const SE3& a) {
  const Eigen::Matrix3d R = a.rotation.toRotationMatrix();
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = R;
  m.topRightCorner<3, 3>() = hat(a.translation) * R;
  m.bottomRightCorner<3, 3>() = R;
  return m;
}

bool is_finite(const SE3& a) {
  return a.rotation.coeffs().allFinite() && a.translation.allFinite();
}

double rotation_angle(const SE3& a) {
  return 2.0 * std::atan2(a.rotation.vec().norm(), std::abs(a.rotation.w()));
}

}  // namespace edvo
