// SPDX-License-Identifier: MIT
#include "edvo/align/motion_support.hpp"
#include "support/matchers.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::motion;
using test::plane_frame;

constexpr SupportLimits kLimits{.intensity = 9, .depth = 0.009F};

Reference wall_reference(const Frame& key) {
  Reference reference = make_reference(key, test::grid_pixels(key, 7), {});
  reference.surface = make_surface(key.depth, kVgaCamera, 14, 0.003);
  return reference;
}

MotionSupport support_of(const Reference& reference, const Frame& frame, const SE3& pose) {
  AlignScratch scratch;
  return motion_support(reference, frame, 0, {.cur_from_ref = pose}, kLimits, scratch);
}

TEST(MotionSupport, OfTheTrueMotionIsAllOfTheImage) {
  const SE3 moved = motion(0.1, 0.02, -0.15, 0.01, -0.01, 0.02);
  const Reference reference = wall_reference(plane_frame({}));
  const MotionSupport support = support_of(reference, plane_frame(moved), inverse(moved));
  EXPECT_GT(support.intensity, 0.99);
  EXPECT_GT(support.depth, 0.99);
  EXPECT_EQ(std::ranges::count(support.states, CellState::kUnexplained), 0);
  const MotionSupport of_none = support_of(reference, plane_frame(moved), {});
  EXPECT_LT(of_none.intensity, 0.7);
  EXPECT_LT(of_none.depth, 0.1);  // 15 cm nearer
}

// Sixty columns of a hundred of the depth image are 30 % nearer.
TEST(MotionSupport, TellsWhatIsNearerAndWhatIsInView) {
  const Reference reference = wall_reference(plane_frame({}));
  RgbdImage image = test::render_plane(test::kPlane, kVgaCamera, {});
  image.depth.colRange(0, image.depth.cols * 6 / 10) *= 0.7F;
  const Undistortion none = make_undistortion({kVgaCamera, {}});
  const MotionSupport hidden = support_of(reference, make_frame(image, none), {});
  EXPECT_NEAR(hidden.nearer, 0.6, 0.03);
  EXPECT_EQ(hidden.farther, 0);
  EXPECT_EQ(hidden.in_view, 1);
  image.depth *= 2;
  EXPECT_NEAR(support_of(reference, make_frame(image, none), {}).farther, 1, 0.03);
  // Half of the image to the right: half of it is left.
  const SE3 right{.translation = {0.5 * kVgaCamera.width / kVgaCamera.fx * 2, 0, 0}};
  EXPECT_NEAR(support_of(reference, plane_frame({}), right).in_view, 0.5, 0.03);
}

// The left half of the image stands still, the right half moves.
TEST(MotionSupport, CountsAreaNotPoints) {
  const Frame key = plane_frame({});
  Frame half = plane_frame(motion(0.3, 0, 0, 0, 0, 0));
  const int middle = kVgaCamera.width / 2;
  cv::Mat_<std::uint8_t> mixed = half.levels[0].gray.clone();
  const cv::Rect left(0, 0, middle, mixed.rows);
  key.levels[0].gray(left).copyTo(mixed(left));
  half.levels[0].gray = mixed;
  std::vector<SelectedPixel> pixels = test::grid_pixels(key, 10);
  const double even = support_of(make_reference(key, pixels, {}), half, {}).intensity;
  for (const SelectedPixel& more : test::grid_pixels(key, 7))
    if (more.pixel.x < middle) pixels.push_back(more);
  const MotionSupport dense = support_of(make_reference(key, pixels, {}), half, {});
  EXPECT_NEAR(dense.intensity, even, 0.01);
  EXPECT_LT(even, 0.8);
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (cell % kCellColumns >= kCellColumns / 2) continue;
    EXPECT_EQ(dense.states[cell], CellState::kExplained) << cell;
  }
}

TEST(MotionSupport, PointsInsideAndOutsideAreAllPoints) {
  const Reference reference = wall_reference(plane_frame({}));
  CellStates states{};
  std::fill_n(states.begin(), kCells / 3, CellState::kUnexplained);
  const Reference inside = points_in(reference, states, CellState::kUnexplained);
  const Reference outside = points_outside(reference, states, CellState::kUnexplained);
  for (std::size_t l = 0; l < reference.levels.size(); ++l) {
    EXPECT_EQ(inside.levels[l].count + outside.levels[l].count, reference.levels[l].count) << l;
    EXPECT_EQ(inside.levels[l].x.size() % 8, 0U);
  }
  EXPECT_GT(inside.levels[0].count, 0U);
  const ReferenceLevel& first = inside.levels[0];
  for (std::size_t i = 0; i < first.count; ++i)
    EXPECT_LT(kVgaCamera.fy * static_cast<double>(first.y[i] / first.z[i]) + kVgaCamera.cy,
              kVgaCamera.height / 3.0 + 1);
}

TEST(MotionSupport, MaskedCellsHaveNoDepthAndOthersKeepIt) {
  const cv::Mat_<float> depth(48, 64, 2.F);
  CellMask mask{};
  mask[0] = mask[kCells - 1] = true;
  const cv::Mat_<float> rest = without_cells(depth, mask);
  EXPECT_TRUE(std::isnan(rest(0, 0)) && std::isnan(rest(3, 3)) && std::isnan(rest(47, 63)));
  EXPECT_EQ(rest(4, 0), 2.F);
  EXPECT_EQ(rest(0, 4), 2.F);
  EXPECT_EQ(depth(0, 0), 2.F);
  EXPECT_EQ(without_cells(depth, {}).data, depth.data);
}

TEST(MotionSupport, CellsMoveWithTheirPoints) {
  const Reference reference = wall_reference(plane_frame({}));
  CellStates states{};
  states[5 * kCellColumns + 4] = CellState::kExplained;
  // Three cells to the right: 120 px at 2 m.
  const SE3 right{.translation = {120.0 / kVgaCamera.fx * 2, 0, 0}};
  const CellMask mask = moved_cells(reference.levels[0], states, CellState::kExplained, right);
  for (int row = 0; row < kCellRows; ++row)
    for (int column = 0; column < kCellColumns; ++column)
      EXPECT_EQ(mask[static_cast<std::size_t>(row * kCellColumns + column)],
                std::abs(row - 5) <= 1 && std::abs(column - 7) <= 1)
          << row << ' ' << column;
}

}  // namespace
}  // namespace edvo
