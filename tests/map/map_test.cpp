// SPDX-License-Identifier: MIT
#include "edvo/map/map.hpp"

#include "support/matchers.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

TEST(Map, KeepsPosesByIdAndCountsChanges) {
  Map map;
  const SE3 there{.translation = {1, 2, 3}};
  EXPECT_EQ(map.add(stamp_from_seconds(1), 0, SE3{}), 0);
  EXPECT_EQ(map.add(stamp_from_seconds(2), 1, there), 1);
  const std::uint64_t before = map.version();
  map.set_pose(0, there);
  EXPECT_GT(map.version(), before);
  EXPECT_THAT(map[0].world_from_camera, test::NearPose(there, 1e-12));
  EXPECT_EQ(map[1].segment, 1);
  EXPECT_EQ(map.keyframes().size(), 2U);
}

TEST(Map, AnIdThatWasNeverGivenThrows) {
  EXPECT_THROW((void)Map()[0], std::out_of_range);
}

}  // namespace
}  // namespace edvo
