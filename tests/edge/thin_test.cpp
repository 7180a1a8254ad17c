// SPDX-License-Identifier: MIT
#include "edvo/edge/thin.hpp"
#include "edvo/edge/network.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

constexpr double kThreshold = 0.5;

cv::Mat_<float> no_edges() {
  return cv::Mat_<float>(60, 80, 0.0F);
}

// Rows of a bar: every column has exactly one edge pixel, at the same row.
TEST(Thin, MakesABarOfAnyWidthOnePixelWide) {
  for (int width = 1; width <= 7; ++width) {
    cv::Mat_<float> strength = no_edges();
    strength.rowRange(20, 20 + width) = 1.0F;
    const cv::Mat_<std::uint8_t> thin = thin_edges(strength, kThreshold);
    EXPECT_EQ(cv::countNonZero(thin), thin.cols) << width;
    const int row = 20 + width / 2;
    const int other = 20 + (width - 1) / 2;  // of an even width either middle row will do
    EXPECT_TRUE(thin(row, 40) != 0 || thin(other, 40) != 0) << width;
    cv::Mat_<float> upright;
    cv::transpose(strength, upright);
    cv::Mat_<std::uint8_t> expected;
    cv::transpose(thin, expected);
    EXPECT_EQ(cv::norm(thin_edges(upright, kThreshold), expected, cv::NORM_INF), 0) << width;
  }
}

TEST(Thin, KeepsARingClosedAndThin) {
  cv::Mat_<float> strength = no_edges();
  cv::circle(strength, {40, 30}, 20, cv::Scalar(1), 5);
  const cv::Mat_<std::uint8_t> thin = thin_edges(strength, kThreshold);
  cv::Mat labels;
  // Its inside and its outside do not touch.
  EXPECT_EQ(cv::connectedComponents(thin == 0, labels, 4), 3);
  for (int y = 0; y + 1 < thin.rows; ++y)
    for (int x = 0; x + 1 < thin.cols; ++x)
      EXPECT_LT(cv::countNonZero(thin(cv::Rect(x, y, 2, 2))), 4) << x << ", " << y;
}

TEST(Thin, KeepsNeighbouringEdgesApart) {
  cv::Mat_<float> strength = no_edges();
  for (const int row : {20, 24, 28}) strength.row(row) = 1.0F;
  const cv::Mat_<std::uint8_t> thin = thin_edges(strength, kThreshold);
  EXPECT_EQ(cv::countNonZero(thin), 3 * thin.cols);
  for (const int row : {20, 24, 28}) EXPECT_EQ(cv::countNonZero(thin.row(row)), thin.cols);
}

TEST(Thin, FindsNothingBelowTheThresholdOrWhereNothingChanges) {
  cv::Mat_<float> strength = no_edges();
  strength.row(20) = 0.49F;
  EXPECT_EQ(cv::countNonZero(thin_edges(strength, kThreshold)), 0);
  EXPECT_EQ(cv::countNonZero(thin_edges(cv::Mat_<float>(60, 80, 1.0F), kThreshold)), 0);
}

TEST(Thin, TakesImagesOfOnePixel) {
  EXPECT_EQ(cv::countNonZero(thin_edges(cv::Mat_<float>(1, 1, 1.0F), kThreshold)), 0);
}

TEST(NetworkEdges, ThresholdFollowsAnImageOfWeakEdges) {
  cv::Mat_<float> weak(60, 80, 0.01F);
  weak.col(40) = 0.2F;
  EXPECT_EQ(cv::countNonZero(network_edges(weak, {.edge_share = 0})), 0);
  EXPECT_EQ(cv::countNonZero(network_edges(weak, {.edge_share = 0.1, .suppress = false})), 60);
  const cv::Mat_<float> blank(60, 80, 0.03F);
  EXPECT_EQ(cv::countNonZero(network_edges(blank, {.edge_share = 0.1, .suppress = false})), 0);
}

}  // namespace
}  // namespace edvo
