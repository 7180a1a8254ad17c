// SPDX-License-Identifier: MIT
#include "edvo/odometry/motion_predictor.hpp"

#include "support/matchers.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::NearPose;

// 2 cm and 0.02 rad in a tenth of a second, seen last at 1 s.
TrackingState moving() {
  const SE3 current_from_last = exp((Vector6d() << 0.02, 0, 0, 0, 0.02, 0).finished());
  return {.stamp = stamp_from_seconds(1.0),
          .alignment = {},
          .last_from_current = inverse(current_from_last),
          .motion_seconds = 0.1};
}

TEST(ConstantVelocity, IsScaledToTheGap) {
  const SE3 twice = exp((Vector6d() << 0.04, 0, 0, 0, 0.04, 0).finished());
  EXPECT_THAT(constant_velocity(moving(), stamp_from_seconds(1.2)), NearPose(twice, 1e-9));
}

TEST(ConstantVelocity, TellsNothingAfterALongGapOrWithoutAMotion) {
  EXPECT_THAT(constant_velocity(moving(), stamp_from_seconds(2.0)), NearPose(SE3{}, 1e-12));
  EXPECT_THAT(constant_velocity({}, stamp_from_seconds(1.1)), NearPose(SE3{}, 1e-12));
}

TEST(PositionPrior, WidensWithTheSquareOfTheGap) {
  const double once = position_prior(moving(), stamp_from_seconds(1.1), 10).sigma;
  EXPECT_NEAR(once, 10 * 0.1 * 0.1, 1e-9);
  EXPECT_NEAR(position_prior(moving(), stamp_from_seconds(1.2), 10).sigma, 4 * once, 1e-9);
}

TEST(PositionPrior, ExpectsNothingAfterALongGap) {
  EXPECT_EQ(position_prior(moving(), stamp_from_seconds(2.0), 10).sigma, 0);
}

TEST(PositionPrior, OfStampsAMicrosecondApartIsNoNarrowerThanOfAMillisecond) {
  TrackingState state = moving();
  state.motion_seconds = 1e-6;
  EXPECT_GE(position_prior(state, stamp_from_seconds(1.000001, 6), 10).sigma, 10 * 1e-3 * 1e-3);
}

}  // namespace
}  // namespace edvo
