// SPDX-License-Identifier: MIT
#include "edvo/odometry/ego_mask.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

constexpr int kWidth = 160, kHeight = 120, kFrames = 6;
constexpr int kCell = kWidth / kCellColumns;
const cv::Rect kCorner(0, 8 * kCell, 6 * kCell, 4 * kCell);  // cells 0 to 5 of the last four rows

// Smooth random texture.
cv::Mat_<std::uint8_t> texture(int seed) {
  cv::Mat_<std::uint8_t> small(kHeight / 2, kWidth), wide;
  cv::RNG random(static_cast<std::uint64_t>(seed));
  random.fill(small, cv::RNG::UNIFORM, 0, 256);
  cv::resize(small, wide, {}, 4, 4, cv::INTER_CUBIC);
  return wide;
}

// A wall at this distance [m] that moves to the left by some pixels per frame.
Frame wall(int i, float distance, int pixels = 5) {
  static const cv::Mat_<std::uint8_t> kWall = texture(1);
  Frame frame;
  frame.levels.push_back({.gray = kWall(cv::Rect(i * pixels, 0, kWidth, kHeight)).clone()});
  frame.depth = cv::Mat_<float>(kHeight, kWidth, distance);
  return frame;
}

// The same with something at rest in the image; distance [m], 0 = as the wall.
Frame with_corner(Frame frame, float distance) {
  static const cv::Mat_<std::uint8_t> kThing = texture(2);
  kThing(kCorner).copyTo(frame.levels.front().gray(kCorner));
  cv::Mat_<float> depth = frame.depth.undistorted().clone();
  if (distance > 0) depth(kCorner).setTo(distance);
  frame.depth = depth;
  return frame;
}

bool is_masked(const EgoMask& mask, int column, int row) {
  return mask.cells()[static_cast<std::size_t>(row * kCellColumns + column)];
}

auto count(const EgoMask& mask) {
  return std::ranges::count(mask.cells(), true);
}

void expect_corner(const EgoMask& mask) {
  EXPECT_TRUE(is_masked(mask, 0, 11) && is_masked(mask, 5, 8));
  EXPECT_TRUE(is_masked(mask, 6, 7)) << "a neighbour";
  EXPECT_EQ(count(mask), 7 * 5);
}

TEST(EgoMask, FindsWhatIsCarriedWithinFourFrames) {
  EgoMask mask;
  for (int i = 0; i < 4; ++i) mask.observe(with_corner(wall(i, 2), 0.5));
  expect_corner(mask);
}

TEST(EgoMask, FindsDirtThroughWhichDepthChanges) {
  EgoMask mask;
  for (int i = 0; i < kFrames; ++i)
    mask.observe(with_corner(wall(i, 2 + 0.2F * static_cast<float>(i)), 0));
  expect_corner(mask);
}

TEST(EgoMask, TakesNoBackgroundForTheCamerasOwn) {
  EgoMask mask;
  for (int i = 0; i < kFrames; ++i) mask.observe(with_corner(wall(i, 2), 4));
  EXPECT_EQ(count(mask), 0);
}

TEST(EgoMask, TakesNoForegroundWhereMoreOfTheSceneRests) {
  EgoMask mask;
  const Frame first = wall(0, 2);
  for (int i = 0; i < kFrames; ++i) {
    Frame frame = with_corner(wall(i, 2), 0.5);
    const cv::Rect still(0, 0, kWidth, 5 * kCell);  // five rows of cells at 2 m
    first.levels.front().gray(still).copyTo(frame.levels.front().gray(still));
    mask.observe(frame);
  }
  EXPECT_EQ(count(mask), 0);
}

TEST(EgoMask, FindsNothingInAMovingOrAStillScene) {
  for (const int pixels : {0, 5}) {
    EgoMask mask;
    for (int i = 0; i < kFrames; ++i) EXPECT_FALSE(mask.observe(wall(i, 2, pixels)));
    EXPECT_EQ(count(mask), 0);
  }
}

TEST(EgoMask, AnEdgeMayMoveAlongItself) {
  EgoMask mask;
  for (int i = 0; i < kFrames; ++i) {
    Frame frame = wall(i, 2);
    cv::Mat_<float> depth = frame.depth.undistorted().clone();
    frame.levels.front().gray(kCorner).setTo(50);
    frame.levels.front().gray.rowRange(10 * kCell + 5, kHeight).colRange(0, 6 * kCell).setTo(200);
    depth(kCorner).setTo(0.5);
    frame.depth = depth;
    mask.observe(frame);
  }
  EXPECT_EQ(count(mask), 0);
}

TEST(EgoMask, ReleasesWhatIsTakenAway) {
  EgoMask mask;
  for (int i = 0; i < kFrames; ++i) mask.observe(with_corner(wall(i, 2), 0.5));
  expect_corner(mask);
  bool has_changed = false;
  for (int i = kFrames; i < 3 * kFrames; ++i) has_changed |= mask.observe(wall(i, 2));
  EXPECT_TRUE(has_changed);
  EXPECT_EQ(count(mask), 0);
}

}  // namespace
}  // namespace edvo
