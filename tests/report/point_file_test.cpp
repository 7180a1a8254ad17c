// SPDX-License-Identifier: MIT
#include "edvo/report/point_file.hpp"

#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <string>

namespace edvo {
namespace {

KeyframePtr keyframe_at(double seconds, const Eigen::Vector3f& point) {
  Keyframe keyframe{.stamp = stamp_from_seconds(seconds)};
  keyframe.world_from_camera.translation = {9, 9, 9};  // as known at the time
  keyframe.points = {{.position = point, .rgb = {1, 2, 3}}};
  return std::make_shared<const Keyframe>(keyframe);
}

TEST(PointFile, PutsPointsWhereTheirKeyframesAreAtTheEnd) {
  const test::TemporaryFolder folder;
  PointFile points(folder.path() / "points.ply");
  EXPECT_TRUE(points.wants_keyframes());
  points.keyframe(keyframe_at(1, {0, 0, 2}));
  points.keyframe(keyframe_at(2, {0, 0, 3}));
  points.keyframe(keyframe_at(3, {0, 0, 4}));
  RunOutcome outcome;  // the last keyframe is not in the map any more
  outcome.keyframes = {{stamp_from_seconds(1), {}},
                       {stamp_from_seconds(2), {.translation = {10, 0, 0}}}};
  points.end(outcome);

  std::ifstream stream(folder.path() / "points.ply", std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  ASSERT_NE(bytes.find("element vertex 2\n"), std::string::npos);
  float second[3];
  std::memcpy(second, bytes.data() + bytes.size() - 15, sizeof second);
  EXPECT_EQ(second[0], 10);
  EXPECT_EQ(second[2], 3);
}

}  // namespace
}  // namespace edvo
