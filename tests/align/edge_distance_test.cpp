// SPDX-License-Identifier: MIT
#include "edvo/align/edge_distance.hpp"

#include "edvo/align/align.hpp"
#include "edvo/features/canny.hpp"
#include "support/matchers.hpp"
#include "support/synthetic_plane.hpp"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <random>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::NearPose;

constexpr float kDepth = 2.F;  // [m]

SE3 motion(double x, double y, double z, double a, double b, double c) {
  Vector6d xi;
  xi << x, y, z, a, b, c;
  return exp(xi);
}

// Cards of many grey levels on a wall at kDepth, moved by (dx, dy) px.
cv::Mat_<std::uint8_t> cards(int dx, int dy) {
  cv::Mat_<std::uint8_t> image(480, 640, std::uint8_t{128});
  std::mt19937 random(7);
  const auto below = [&](unsigned limit) { return static_cast<int>(random() % limit); };
  for (int i = 0; i < 60; ++i) {
    const cv::Point corner(below(640) + dx, below(480) + dy);
    const cv::Size size(30 + below(70), 30 + below(70));
    cv::rectangle(image, cv::Rect(corner, size), cv::Scalar(30 + below(200)), cv::FILLED);
  }
  return image;
}

Frame card_frame(const cv::Mat_<std::uint8_t>& gray) {
  RgbdImage image;
  cv::cvtColor(gray, image.bgr, cv::COLOR_GRAY2BGR);
  image.depth = cv::Mat_<float>(gray.size(), kDepth);
  Frame frame = make_frame(image, make_undistortion({kVgaCamera, {}}), {});
  frame.edge_distance = make_edge_distance(canny_edges(frame.levels.front().gray, {}),
                                           static_cast<int>(frame.levels.size()));
  return frame;
}

Reference card_reference(const Frame& frame, double gradient_weight_scale) {
  std::vector<SelectedPixel> pixels;
  const cv::Mat_<float>& distance = frame.edge_distance.front();
  for (int y = 20; y < 460; ++y)
    for (int x = 20; x < 620; ++x)
      if (distance(y, x) == 0) pixels.push_back({{x, y}, kDepth, 1.F});
  Reference reference =
      make_reference(frame, pixels, {.gradient_weight_scale = gradient_weight_scale});
  reference.edge_points = edge_points(frame.edge_distance, kVgaCamera, pixels);
  return reference;
}

TEST(EdgeDistance, HoldsPixelsToTheNearestEdgeUpToTheFarthest) {
  cv::Mat_<std::uint8_t> edges(64, 64, std::uint8_t{0});
  edges(16, 16) = 255;
  const EdgeDistance distance = make_edge_distance(edges, 3);
  ASSERT_EQ(distance.size(), 3U);
  EXPECT_FLOAT_EQ(distance[0](16, 16), 0);
  EXPECT_FLOAT_EQ(distance[0](19, 20), 5);
  EXPECT_FLOAT_EQ(distance[0](16, 40), kFarthestEdge);
  EXPECT_EQ(distance[1].size(), cv::Size(32, 32));
  EXPECT_FLOAT_EQ(distance[1](8, 12), 4);  // 8 pixels of the full image
  EXPECT_FLOAT_EQ(distance[2](4, 10), 6);
}

TEST(EdgeDistance, OfAnImageWithoutEdgesIsTheFarthestEverywhere) {
  const EdgeDistance distance =
      make_edge_distance(cv::Mat_<std::uint8_t>(48, 64, std::uint8_t{0}), 2);
  for (const cv::Mat_<float>& level : distance)
    EXPECT_EQ(cv::countNonZero(level != kFarthestEdge), 0);
}

TEST(EdgeDistance, LevelsHaveTheSizeOfThePyramidsAlsoWhenOdd) {
  const EdgeDistance distance =
      make_edge_distance(cv::Mat_<std::uint8_t>(45, 67, std::uint8_t{0}), 3);
  EXPECT_EQ(distance[1].size(), cv::Size(34, 23));
  EXPECT_EQ(distance[2].size(), cv::Size(17, 12));
}

TEST(EdgeDistance, PointsAreTheSelectedPixelsOnEdges) {
  cv::Mat_<std::uint8_t> edges(480, 640, std::uint8_t{0});
  edges(100, 200) = 255;
  const auto points = edge_points(make_edge_distance(edges, 1), kVgaCamera,
                                  {{{200, 100}, kDepth, 1.F}, {{205, 100}, kDepth, 1.F}});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(project(kVgaCamera, points[0].cast<double>()).x(), 200, 1e-3);
}

TEST(EdgeDistance, GradientMatchesNumericDifferencesOfTheCost) {
  // The distance to a straight line is linear, so that reading between pixels is exact.
  cv::Mat_<float> distance(480, 640);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u)
      distance(v, u) = 0.006F * static_cast<float>(u) + 0.008F * static_cast<float>(v);
  const SE3 pose = motion(0.05, -0.03, 0.1, 0.05, -0.1, 0.2);
  constexpr double kStep = 1e-3;
  for (const Eigen::Vector3f& p :
       {Eigen::Vector3f(0.1F, -0.2F, 1.5F), Eigen::Vector3f(0.4F, 0.3F, 2),
        Eigen::Vector3f(-0.5F, -0.1F, 1.8F)})
    for (const float sigma : {0.5F, 10.F}) {  // beyond Huber's threshold, and within
      const auto sums_at = [&](const SE3& at) {
        return sum_edge_distance({p}, kVgaCamera, distance, at, sigma, 3.F);
      };
      const PoseSums sums = sums_at(pose);
      for (int k = 0; k < 6; ++k) {
        Vector6d xi = Vector6d::Zero();
        xi[k] = kStep;
        const double numeric =
            (sums_at(pose * exp(xi)).cost - sums_at(pose * exp(-xi)).cost) / (2 * kStep);
        EXPECT_NEAR(sums.gradient[k], numeric, 2e-3 * sums.gradient.norm()) << k;
      }
      if (sigma < 1) continue;
      // Of one point: J' W J = (J' W r) (J' W r)' / (r' W r).
      const Matrix6d outer = sums.gradient * sums.gradient.transpose() / (2 * sums.cost);
      const Matrix6d hessian = sums.hessian.selfadjointView<Eigen::Upper>();
      EXPECT_LT((hessian - outer).norm(), 1e-4 * outer.norm());
    }
}

TEST(EdgeDistance, PointsOutOfViewPayTheLossOfTheFarthestEdge) {
  const cv::Mat_<float> nothing(480, 640, kFarthestEdge);
  const Eigen::Vector3f seen(0, 0, 2), beside(9, 0, 2), behind(0, 0, -2);
  const auto cost = [&](const Eigen::Vector3f& p) {
    return sum_edge_distance({p}, kVgaCamera, nothing, {}, 1, 1).cost;
  };
  EXPECT_GT(cost(seen), 0);
  EXPECT_DOUBLE_EQ(cost(beside), cost(seen));
  EXPECT_DOUBLE_EQ(cost(behind), cost(seen));
}

TEST(EdgeDistance, AlignsToANegativeWhereIntensitiesCannot) {
  const Frame key = card_frame(cards(0, 0));
  cv::Mat_<std::uint8_t> inverted = cards(9, -6);
  cv::bitwise_not(inverted, inverted);
  const Frame negative = card_frame(inverted);
  const SE3 truth = motion(9 * 2.0 / 525, -6 * 2.0 / 525, 0, 0, 0, 0);
  AlignOptions options{.min_sigma = 100, .brightness = false, .depth_weight = 0};
  const Reference reference = card_reference(key, 4);
  const SE3 by_intensity = align(reference, negative, {}, options).alignment.cur_from_ref;
  options.edge_distance = 10;
  const SE3 by_edges = align(reference, negative, {}, options).alignment.cur_from_ref;
  EXPECT_THAT(by_edges, NearPose(truth, 1e-3));
  EXPECT_GT((by_intensity.translation - truth.translation).norm(), 0.01);
}

TEST(EdgeDistance, LeavesAPhotometricAlignmentWhereItIs) {
  const Frame key = card_frame(cards(0, 0));
  const Frame moved = card_frame(cards(4, 3));
  const SE3 truth = motion(4 * 2.0 / 525, 3 * 2.0 / 525, 0, 0, 0, 0);
  const AlignResult result =
      align(card_reference(key, 40), moved, {},
            {.step_tolerance = 0.01, .depth_weight = 0, .edge_distance = 0.1});
  EXPECT_EQ(result.status, AlignStatus::kTracked);
  EXPECT_THAT(result.alignment.cur_from_ref, NearPose(truth, 5e-4));
}

TEST(EdgeDistance, IsOffForAFrameWithoutDistances) {
  const Frame key = card_frame(cards(0, 0));
  Frame moved = card_frame(cards(4, 3));
  moved.edge_distance.clear();
  const Reference reference = card_reference(key, 40);
  const AlignResult with = align(reference, moved, {}, {.edge_distance = 1});
  const AlignResult without = align(reference, moved, {}, {});
  EXPECT_EQ(with.alignment.cur_from_ref.translation, without.alignment.cur_from_ref.translation);
}

}  // namespace
}  // namespace edvo
