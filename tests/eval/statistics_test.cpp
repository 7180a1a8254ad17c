// SPDX-License-Identifier: MIT
#include "edvo/eval/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo {
namespace {

TEST(Statistics, AreThoseOfNumpy) {
  const Statistics s = statistics({4, 1, 2, 5});
  EXPECT_DOUBLE_EQ(s.mean, 3);
  EXPECT_DOUBLE_EQ(s.median, 3);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(46.0 / 4));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(2.5));  // of the population
  EXPECT_DOUBLE_EQ(s.min, 1);
  EXPECT_DOUBLE_EQ(s.max, 5);
}

TEST(Statistics, OfOneValueAreThatValue) {
  const Statistics s = statistics({2});
  EXPECT_EQ(s.rmse, 2);
  EXPECT_EQ(s.median, 2);
  EXPECT_EQ(s.std, 0);
}

TEST(Statistics, OfNothingAreZero) {
  EXPECT_EQ(statistics({}).rmse, 0);
  EXPECT_EQ(median({}), 0);
}

TEST(Statistics, MedianOfAnOddNumberIsTheMiddleOne) {
  EXPECT_EQ(median({9, 1, 5}), 5);
}

}  // namespace
}  // namespace edvo
