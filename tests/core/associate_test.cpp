// SPDX-License-Identifier: MIT
#include "edvo/core/associate.hpp"

#include "support/error_matcher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <utility>

namespace edvo {
namespace {

using testing::ElementsAre;
using testing::Pair;

constexpr double kGap = 0.02;  // [s]

std::vector<Stamp> stamps(std::initializer_list<double> seconds) {
  std::vector<Stamp> all;
  for (const double s : seconds) all.push_back(stamp_from_seconds(s));
  return all;
}

std::vector<std::pair<std::size_t, std::size_t>> pairs(std::initializer_list<double> first,
                                                       std::initializer_list<double> second) {
  std::vector<std::pair<std::size_t, std::size_t>> all;
  for (const auto [i, j] : associate(std::vector(first), std::vector(second), kGap))
    all.emplace_back(i, j);
  return all;
}

TEST(Associate, TakesTheSmallestGapFirst) {
  // 1.010 is within reach of both; the nearer one gets it, the other one goes on to 0.990.
  EXPECT_THAT(pairs({1.000, 1.012}, {0.990, 1.010}), ElementsAre(Pair(0, 0), Pair(1, 1)));
  EXPECT_THAT(pairs({1.000, 1.012}, {1.010}), ElementsAre(Pair(1, 0)));
}

TEST(Associate, UsesEachStampOnce) {
  EXPECT_THAT(pairs({1.0, 1.001, 1.002}, {1.0, 1.001}), ElementsAre(Pair(0, 0), Pair(1, 1)));
}

TEST(Associate, LeavesOutPairsAtTheLargestGap) {
  EXPECT_THAT(pairs({1.0}, {1.02}), ElementsAre());
  EXPECT_THAT(pairs({1.0}, {1.019999}), ElementsAre(Pair(0, 0)));
  EXPECT_THAT(pairs({1.02}, {1.0}), ElementsAre());
}

TEST(Associate, EqualGapsGoToTheEarlierStamp) {
  EXPECT_THAT(pairs({1.0, 1.01}, {1.005}), ElementsAre(Pair(0, 0)));
}

TEST(Associate, NothingIsPairedWithNothing) {
  EXPECT_THAT(pairs({}, {1.0}), ElementsAre());
  EXPECT_THAT(pairs({1.0}, {}), ElementsAre());
}

TEST(Associate, RefusesStampsThatAreTooDense) {
  std::vector<double> dense;
  for (int i = 0; i < 2000; ++i) dense.push_back(1e-9 * i);
  EXPECT_TRUE(test::fails_with(ErrorCode::kInput, {"in seconds?"},
                               [&] { (void)associate(dense, dense, kGap, 200); }));
}

TEST(Associate, SmallestGapLooksBothWays) {
  EXPECT_DOUBLE_EQ(smallest_gap(stamps({1.0, 5.0}), stamps({2.0, 4.5, 9.0})), 0.5);
  EXPECT_DOUBLE_EQ(smallest_gap(stamps({10.0}), stamps({1.0, 2.0})), 8.0);
}

}  // namespace
}  // namespace edvo
