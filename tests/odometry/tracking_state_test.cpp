// SPDX-License-Identifier: MIT
#include "edvo/odometry/tracking_state.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

TEST(TrackingState, ExpectsNoLargerResidualsAfterSomeWrongPoses) {
  EXPECT_EQ(expected_sigma({}), 0);
  EXPECT_EQ(expected_sigma({.usual_sigma = 5, .low_sigma = 4}), 5);
  EXPECT_EQ(expected_sigma({.usual_sigma = 15, .low_sigma = 4}), 8);
}

}  // namespace
}  // namespace edvo
