// SPDX-License-Identifier: MIT
#include "edvo/frame/frame.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

double difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}

TEST(Smoothed, BlursItsOwnFullImageOnly) {
  const Frame frame = test::plane_frame({});
  const cv::Mat sharp = frame.levels[0].gray.clone();
  const Frame blurred = smoothed(frame, 1.0);
  EXPECT_GT(difference(blurred.levels[0].gray, sharp), 0);
  EXPECT_EQ(difference(frame.levels[0].gray, sharp), 0);
  ASSERT_EQ(blurred.levels.size(), frame.levels.size());
  for (std::size_t l = 1; l < frame.levels.size(); ++l)
    EXPECT_EQ(difference(blurred.levels[l].gray, frame.levels[l].gray), 0) << l;
  EXPECT_EQ(difference(smoothed(frame, 0).levels[0].gray, sharp), 0);
}

}  // namespace
}  // namespace edvo
