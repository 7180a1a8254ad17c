// SPDX-License-Identifier: MIT
#include "edvo/core/se3.hpp"

#include "support/matchers.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <vector>

namespace edvo {
namespace {

using test::NearPose;

constexpr double kExact = 1e-12;

// Zero, tiny, ordinary and nearly half a turn, along and across the axes.
std::vector<Vector6d> twists() {
  std::vector<Vector6d> all;
  for (const double angle :
       {0.0, 1e-12, 1e-7, 0.99e-4, 1.01e-4, 0.1, 1.0, 3.0, std::numbers::pi - 1e-6})
    for (const Eigen::Vector3d& axis :
         {Eigen::Vector3d{1, 0, 0}, Eigen::Vector3d{0, -1, 0}, Eigen::Vector3d{1, 2, -3}}) {
      Vector6d xi;
      xi << 0.3, -2.0, 5.0, angle * axis.normalized();
      all.push_back(xi);
    }
  return all;
}

TEST(SE3, LogInvertsExp) {
  for (const Vector6d& xi : twists()) EXPECT_LT((log(exp(xi)) - xi).norm(), 1e-8) << xi.transpose();
}

TEST(SE3, InverseUndoes) {
  for (const Vector6d& xi : twists())
    EXPECT_THAT(exp(xi) * inverse(exp(xi)), NearPose(SE3{}, kExact));
}

TEST(SE3, ExpOfTheNegativeIsTheInverse) {
  for (const Vector6d& xi : twists()) EXPECT_THAT(exp(-xi), NearPose(inverse(exp(xi)), 1e-11));
}

TEST(SE3, CompositionIsAssociativeAndActsOnPoints) {
  const Eigen::Vector3d point{1.0, -2.0, 3.0};
  for (const Vector6d& a : twists())
    for (const Vector6d& b : twists()) {
      const SE3 A = exp(a), B = exp(b);
      EXPECT_LT(((A * B) * point - A * (B * point)).norm(), 1e-11);
      EXPECT_THAT((A * B) * A, NearPose(A * (B * A), 1e-11));
    }
}

TEST(SE3, AdjointMovesATwistAcross) {
  Vector6d small;
  small << 0.01, -0.02, 0.03, 0.02, 0.01, -0.03;
  for (const Vector6d& xi : twists()) {
    const SE3 A = exp(xi);
    EXPECT_THAT(A * exp(small) * inverse(A), NearPose(exp(adjoint(A) * small), 1e-10));
  }
}

TEST(SE3, ExpMatchesItsSeriesAtSmallAngles) {
  Vector6d xi;
  xi << 1.0, 2.0, 3.0, 0.9e-4, 0.2e-4, -0.1e-4;
  const Eigen::Matrix3d W = hat(xi.tail<3>());
  const Eigen::Matrix3d R = Eigen::Matrix3d::Identity() + W + 0.5 * W * W;
  EXPECT_LT((exp(xi).rotation.toRotationMatrix() - R).norm(), kExact);
}

}  // namespace
}  // namespace edvo
