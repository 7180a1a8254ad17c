// SPDX-License-Identifier: MIT
#include "support/synthetic_plane.hpp"

#include <gtest/gtest.h>

namespace edvo::test {
namespace {

const SyntheticPlane kPlane{.distance = 2.0};

SE3 tilted() {
  Vector6d xi;
  xi << 0.1, -0.2, 0.3, 0.2, -0.15, 0.1;
  return exp(xi);
}

TEST(SyntheticPlane, GradientMatchesNumericDifferences) {
  constexpr double kStep = 1e-4;  // [px]
  for (const double u : {10.0, 80.3, 150.0})
    for (const double v : {5.0, 60.7, 110.0}) {
      const auto at = [&](double du, double dv) {
        return intensity_at(kPlane, kSmallCamera, tilted(), u + du, v + dv);
      };
      const Eigen::Vector2d numeric{(at(kStep, 0) - at(-kStep, 0)) / (2 * kStep),
                                    (at(0, kStep) - at(0, -kStep)) / (2 * kStep)};
      EXPECT_LT((gradient_at(kPlane, kSmallCamera, tilted(), u, v) - numeric).norm(), 1e-6);
    }
}

TEST(SyntheticPlane, DepthPutsPixelsOnThePlane) {
  const cv::Mat_<float> depth = render_plane_depth(kPlane, kSmallCamera, tilted());
  for (int y = 0; y < depth.rows; y += 7)
    for (int x = 0; x < depth.cols; x += 7) {
      const Eigen::Vector3d point = tilted() * back_project(kSmallCamera, x, y, depth(y, x));
      EXPECT_NEAR(point.z(), kPlane.distance, 1e-6);
    }
}

TEST(SyntheticPlane, TwoViewsShowTheSameIntensityAtTheSamePoint) {
  for (const double u : {20.0, 75.0, 140.0}) {
    const double z = depth_at(kPlane, kSmallCamera, SE3{}, u, 60);
    const Eigen::Vector2d seen =
        project(kSmallCamera, inverse(tilted()) * back_project(kSmallCamera, u, 60, z));
    EXPECT_NEAR(intensity_at(kPlane, kSmallCamera, tilted(), seen.x(), seen.y()),
                intensity_at(kPlane, kSmallCamera, SE3{}, u, 60), 1e-9);
  }
}

TEST(SyntheticPlane, NeverSaturatesItsEightBits) {
  const cv::Mat_<float> gray = render_plane_gray(kPlane, kVgaCamera, SE3{});
  double lowest = 0, highest = 0;
  cv::minMaxLoc(gray, &lowest, &highest);
  EXPECT_GT(lowest, 0);
  EXPECT_LT(highest, 255);
  EXPECT_GT(highest - lowest, 100);
}

}  // namespace
}  // namespace edvo::test
