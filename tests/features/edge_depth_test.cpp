// SPDX-License-Identifier: MIT
#include "edvo/features/edge_depth.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr int kSize = 40;     // [px]
constexpr int kMargin = 4;    // [px]
constexpr float kWall = 3.F;  // [m]

cv::Mat_<float> wall() {
  return cv::Mat_<float>(kSize, kSize, kWall);
}

// A foreground of 1 m left of column 20, the wall right of it.
cv::Mat_<float> box_before_wall() {
  cv::Mat_<float> depth = wall();
  depth(cv::Rect(0, 0, 20, kSize)) = 1.F;
  return depth;
}

// Whether the pixel's own depth is taken.
bool keeps(const cv::Mat_<float>& depth, cv::Point pixel) {
  return edge_depth(depth, pixel) == depth(pixel);
}

int pixels_kept(const cv::Mat_<float>& depth) {
  int kept = 0;
  for (int y = kMargin; y < kSize - kMargin; ++y)
    for (int x = kMargin; x < kSize - kMargin; ++x) kept += keeps(depth, {x, y});
  return kept;
}

TEST(EdgeDepth, KeepsTheForegroundAtAJumpAndDropsTheBackgroundBesideIt) {
  const cv::Mat_<float> depth = box_before_wall();
  EXPECT_TRUE(keeps(depth, {19, 20}));
  EXPECT_TRUE(keeps(depth, {17, 20}));
  EXPECT_FALSE(keeps(depth, {20, 20}));
  EXPECT_TRUE(keeps(depth, {23, 20}));
}

TEST(EdgeDepth, APixelBesideTheNearestSurfaceGetsItsDepthAndOneFartherOffNone) {
  const cv::Mat_<float> depth = box_before_wall();
  EXPECT_EQ(edge_depth(depth, {20, 20}), 1.F);
  EXPECT_TRUE(std::isnan(edge_depth(depth, {21, 20})));
}

TEST(EdgeDepth, AStrayDepthOnAWallIsReplacedByTheWalls) {
  cv::Mat_<float> depth = wall();
  depth(20, 20) = 0.7F;
  EXPECT_EQ(edge_depth(depth, {20, 20}), kWall);
}

TEST(EdgeDepth, DropsAStrayNearDepthAndKeepsThePixelsAroundIt) {
  cv::Mat_<float> depth = wall();
  depth(20, 20) = 0.7F;
  EXPECT_FALSE(keeps(depth, {20, 20}));
  EXPECT_TRUE(keeps(depth, {21, 20}));
  EXPECT_TRUE(keeps(depth, {18, 19}));
}

TEST(EdgeDepth, DropsFlyingPixelsBetweenForegroundAndBackground) {
  cv::Mat_<float> depth = box_before_wall();
  for (int y = 0; y < kSize; ++y) {
    depth(y, 20) = 1.4F + 0.01F * static_cast<float>(y);
    depth(y, 21) = 2.2F - 0.01F * static_cast<float>(y);
  }
  EXPECT_TRUE(keeps(depth, {19, 20}));
  EXPECT_FALSE(keeps(depth, {20, 20}));
  EXPECT_FALSE(keeps(depth, {21, 20}));
}

TEST(EdgeDepth, DropsASpeckleBlobOfThreeByThreePixels) {
  cv::Mat_<float> depth = wall();
  depth(cv::Rect(19, 19, 3, 3)) = 1.8F;
  EXPECT_FALSE(keeps(depth, {20, 20}));
  EXPECT_FALSE(keeps(depth, {19, 21}));
  EXPECT_TRUE(keeps(depth, {22, 20}));
}

TEST(EdgeDepth, KeepsAllOfTheWallUnderStrayDepthsOfATenthOfThePixels) {
  cv::Mat_<float> depth = wall();
  cv::RNG random(3);
  int strays = 0;
  for (float& z : depth)
    if (random.uniform(0, 10) == 0) {
      z = random.uniform(0.3F, 2.8F);
      ++strays;
    }
  ASSERT_GT(strays, 100);
  for (int y = kMargin; y < kSize - kMargin; ++y)
    for (int x = kMargin; x < kSize - kMargin; ++x)
      EXPECT_EQ(keeps(depth, {x, y}), depth(y, x) == kWall) << x << ' ' << y;
}

// The depth edge lies off the image edge, which depth alone cannot tell: the background's texture
// that got the foreground's depth is kept with it, the background itself is not.
TEST(EdgeDepth, GivesNoPixelAnotherDepthAtADilatedForeground) {
  cv::Mat_<float> depth = wall();
  depth(cv::Rect(0, 0, 24, kSize)) = 1.F;  // of 20 columns
  EXPECT_TRUE(keeps(depth, {21, 20}));
  EXPECT_FALSE(keeps(depth, {25, 20}));
}

TEST(EdgeDepth, KeepsTheForegroundBesideAHole) {
  cv::Mat_<float> depth = box_before_wall();
  depth(cv::Rect(20, 0, 6, kSize)) = kNone;
  EXPECT_TRUE(keeps(depth, {19, 20}));
  EXPECT_FALSE(keeps(depth, {21, 20}));
  EXPECT_TRUE(keeps(depth, {26, 20}));
}

TEST(EdgeDepth, KeepsAPixelWithFewNeighboursThatAllAgree) {
  cv::Mat_<float> depth(kSize, kSize, kNone);
  depth(20, 20) = depth(21, 20) = 2.F;
  EXPECT_TRUE(keeps(depth, {20, 20}));
  EXPECT_FALSE(keeps(depth, {22, 20}));
  depth(19, 20) = 1.F;
  EXPECT_FALSE(keeps(depth, {20, 20}));
}

TEST(EdgeDepth, KeepsAThinPoleOfTwoPixels) {
  cv::Mat_<float> depth = wall();
  depth(cv::Rect(20, 0, 2, kSize)) = 1.F;
  EXPECT_TRUE(keeps(depth, {20, 20}));
  EXPECT_TRUE(keeps(depth, {21, 20}));
  EXPECT_FALSE(keeps(depth, {19, 20}));
}

TEST(EdgeDepth, KeepsASlantedSurfaceOfOnePercentAPixel) {
  cv::Mat_<float> depth(kSize, kSize);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) depth(y, x) = 2.F / (1 + 0.01F * static_cast<float>(y));
  EXPECT_GT(pixels_kept(depth), 0.95 * (kSize - 2 * kMargin) * (kSize - 2 * kMargin));
}

TEST(EdgeDepth, ReadsOnlyTheSevenBySevenPixelsAround) {
  cv::Mat_<float> depth = wall();
  depth(cv::Rect(0, 0, kSize, 17)) = 1.F;
  depth(cv::Rect(24, 0, kSize - 24, kSize)) = 1.F;
  depth(cv::Rect(0, 0, 17, kSize)) = 1.F;
  depth(cv::Rect(0, 24, kSize, kSize - 24)) = 1.F;
  EXPECT_TRUE(keeps(depth, {20, 20}));
  EXPECT_FALSE(keeps(depth, {22, 20}));  // two columns of the nearer
}

}  // namespace
}  // namespace edvo
