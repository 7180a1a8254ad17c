// SPDX-License-Identifier: MIT
#include "edvo/features/canny.hpp"
#include "edvo/features/corners.hpp"
#include "edvo/features/edge_strength.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Bright squares of side `size` on black, corners at their four corners.
cv::Mat_<std::uint8_t> squares(const std::vector<cv::Point>& at, int size) {
  cv::Mat_<std::uint8_t> image(120, 160, std::uint8_t{0});
  for (const cv::Point& p : at) cv::rectangle(image, {p.x, p.y, size, size}, cv::Scalar(255), -1);
  return image;
}

TEST(Corners, AppearAtTheCornersOfASquareAndNotAlongItsSides) {
  const auto corners = optimize_corners(squares({{50, 30}}, 40), {.crowded = 100});
  ASSERT_EQ(corners.size(), 4U);
  for (const Corner& corner : corners) {
    const bool near_x =
        std::min(std::abs(corner.position.x - 50), std::abs(corner.position.x - 89)) <= 2;
    const bool near_y =
        std::min(std::abs(corner.position.y - 30), std::abs(corner.position.y - 69)) <= 2;
    EXPECT_TRUE(near_x && near_y) << corner.position;
  }
}

TEST(Corners, ResponseIsTheSmallerEigenvalue) {
  cv::Mat_<std::uint8_t> ramp(40, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) ramp(y, x) = static_cast<std::uint8_t>(3 * x);
  // A ramp has gradients in one direction only: the smaller eigenvalue is zero.
  EXPECT_NEAR(min_eigenvalue(ramp, 1.5)(20, 20), 0.F, 1e-7F);
}

TEST(Corners, ACrowdedWindowIsClearedAndGetsItsBudgetBack) {
  std::vector<cv::Point> dense;  // 4 x 2-pixel squares within one 20 x 20 window
  for (const int x : {1, 11})
    for (const int y : {1, 11}) dense.push_back({x + 40, y + 40});
  const cv::Mat_<std::uint8_t> image = squares(dense, 6);
  const CornerOptions roomy{.quality = 0.01, .crowded = 1000};
  const CornerOptions strict{
      .quality = 0.01, .crowded = 4, .budget = 2, .strict_quality = 0.1, .min_distance = 6};
  const auto in_window = [](const std::vector<Corner>& corners) {
    return std::count_if(corners.begin(), corners.end(), [](const Corner& c) {
      return cv::Rect(40, 40, 20, 20).contains(c.position);
    });
  };
  EXPECT_GT(in_window(optimize_corners(image, roomy)), 4);
  const auto kept = optimize_corners(image, strict);
  EXPECT_EQ(in_window(kept), 2);
}

TEST(Corners, SecondExtractionKeepsItsDistance) {
  std::vector<cv::Point> dense;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y) dense.push_back({42 + 6 * x, 42 + 6 * y});
  const auto kept = optimize_corners(
      squares(dense, 3),
      {.quality = 0.01, .crowded = 2, .budget = 50, .strict_quality = 0, .min_distance = 9});
  for (std::size_t a = 0; a < kept.size(); ++a)
    for (std::size_t b = a + 1; b < kept.size(); ++b) {
      const cv::Point same{kept[a].position.x / 20 - kept[b].position.x / 20,
                           kept[a].position.y / 20 - kept[b].position.y / 20};
      if (same != cv::Point{0, 0}) continue;  // the rule holds within a window
      const cv::Point d = kept[a].position - kept[b].position;
      EXPECT_GE(d.ddot(d), 81.0);
    }
}

TEST(Corners, ABlankImageHasNone) {
  EXPECT_TRUE(optimize_corners(cv::Mat_<std::uint8_t>(60, 80, std::uint8_t{0}), {}).empty());
}

TEST(Corners, ADiscHoldsItsRadiusAndNoMore) {
  const auto mask = draw_discs({40, 40}, {{.position = {20, 20}, .response = 1}}, 3);
  EXPECT_EQ(mask(20, 23), 255);
  EXPECT_EQ(mask(20, 24), 0);
  EXPECT_EQ(mask(23, 23), 0);
}

// A bright square of 40 px in the middle of the image.
cv::Mat_<std::uint8_t> bright_square() {
  cv::Mat_<std::uint8_t> image(120, 160, std::uint8_t{30});
  cv::rectangle(image, {50, 30, 40, 40}, cv::Scalar(200), -1);
  return image;
}

cv::Mat_<std::uint8_t> noisy_wall() {
  cv::Mat_<std::uint8_t> wall(120, 160);
  for (int y = 0; y < wall.rows; ++y)
    for (int x = 0; x < wall.cols; ++x)
      wall(y, x) = static_cast<std::uint8_t>(128 + (x * 7 + y * 13) % 3);
  return wall;
}

TEST(Canny, FindsTheOutlineOfASquareOnePixelWide) {
  const auto edges = canny_edges(bright_square(), {});
  EXPECT_NEAR(cv::countNonZero(edges), 4 * 40, 20);
  EXPECT_EQ(cv::countNonZero(edges(cv::Rect(55, 35, 30, 30))), 0);
}

TEST(Canny, SeesNoEdgesInNoiseOnABlankWall) {
  EXPECT_LT(cv::countNonZero(canny_edges(noisy_wall(), {})), 100);
}

TEST(Canny, ThresholdFollowsTheContrastOfTheImage) {
  cv::Mat_<std::uint8_t> strong(120, 160, std::uint8_t{20}), weak(120, 160, std::uint8_t{100});
  cv::rectangle(strong, {50, 30, 40, 40}, cv::Scalar(220), -1);
  cv::rectangle(weak, {50, 30, 40, 40}, cv::Scalar(125), -1);
  EXPECT_NEAR(cv::countNonZero(canny_edges(weak, {})), cv::countNonZero(canny_edges(strong, {})),
              10);
}

TEST(Canny, LeavesItsImageAsItWas) {
  const cv::Mat_<std::uint8_t> image = bright_square();
  const cv::Mat before = image.clone();
  (void)canny_edges(image, {.blur_sigma = 2});
  EXPECT_EQ(cv::norm(image, before, cv::NORM_INF), 0);
}

// Two squares of the same contrast; the network sees the left one, a pixel outside of its outline.
struct TwoSquares {
  cv::Mat_<std::uint8_t> gray = cv::Mat_<std::uint8_t>(120, 160, std::uint8_t{30});
  cv::Mat_<float> strength = cv::Mat_<float>(120, 160, 0.F);
  cv::Rect left{0, 0, 80, 120}, right{80, 0, 80, 120};
  TwoSquares() {
    for (const int x : {20, 100}) cv::rectangle(gray, {x, 30, 40, 40}, cv::Scalar(200), -1);
    cv::rectangle(strength, {19, 29, 42, 42}, cv::Scalar(1));
  }
};

TEST(NetworkEdges, AreWhereTheNetworkSeesThemAndTheImageSteps) {
  const TwoSquares squares;
  const auto edges = edges_of_strength(squares.strength, squares.gray, {});
  EXPECT_EQ(cv::countNonZero(edges(squares.right)), 0);
  EXPECT_NEAR(cv::countNonZero(edges(squares.left)), 4 * 40, 20);
  cv::Mat_<std::uint8_t> outline(edges.size(), std::uint8_t{0});  // both sides of the step
  cv::rectangle(outline, {19, 29, 42, 42}, cv::Scalar(255));
  cv::rectangle(outline, {20, 30, 40, 40}, cv::Scalar(255));
  EXPECT_EQ(cv::countNonZero(edges & ~outline), 0);
}

TEST(NetworkEdges, WithoutInfluenceAreCannys) {
  const TwoSquares squares;
  const auto edges =
      edges_of_strength(squares.strength, squares.gray, {.edge_exponent = 0, .canny = {}});
  EXPECT_EQ(cv::norm(edges, canny_edges(squares.gray, {}), cv::NORM_INF), 0);
}

TEST(NetworkEdges, WeakStrengthOnANoisyWallMakesNone) {
  const cv::Mat_<std::uint8_t> wall = noisy_wall();
  const cv::Mat_<float> strength(wall.size(), 0.03F);
  EXPECT_EQ(cv::countNonZero(edges_of_strength(strength, wall, {})), 0);
}

}  // namespace
}  // namespace edvo
