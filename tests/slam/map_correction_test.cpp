// SPDX-License-Identifier: MIT
#include "edvo/slam/map_correction.hpp"

#include "support/matchers.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::NearPose;

SE3 motion(double x, double y, double yaw) {
  return exp((Vector6d() << x, y, 0, 0, 0, yaw).finished());
}

Matrix6d information() {
  return 1e4 * Matrix6d::Identity();  // sigmas of 1 cm and 0.01 rad
}

LinkReport link_between(std::int64_t from, std::int64_t to, const SE3& from_pose_to) {
  LinkReport link{.from = from, .to = to, .status = LinkStatus::kAccepted};
  link.from_pose_to = from_pose_to;
  link.alike = 0.9;
  link.information = information();
  return link;
}

struct World {
  std::vector<SE3> truth;
  std::vector<MapKeyframe> map;
  std::vector<OdometryStep> steps;
};

// Once around a square; what the map tells drifts from step to step.
World around(const SE3& drift) {
  World world;
  SE3 truth, pose;
  for (int i = 0; i < 16; ++i) {
    world.truth.push_back(truth);
    world.map.push_back({.id = i, .stamp = stamp_from_seconds(i, 6), .world_from_camera = pose});
    const SE3 step = motion(0.25, 0, i % 4 == 3 ? 1.5707963 : 0);
    if (i < 15)
      world.steps.push_back(
          {.from = i, .to = i + 1, .from_pose_to = step * drift, .information = information()});
    truth = truth * step;
    pose = pose * step * drift;
  }
  return world;
}

SE3 between(const std::vector<SE3>& poses, std::size_t from, std::size_t to) {
  return inverse(poses[from]) * poses[to];
}

double distance_of_last(const World& world) {
  return (world.map.back().world_from_camera.translation - world.truth.back().translation).norm();
}

TEST(CloseLoops, TakesDriftOut) {
  World world = around(motion(0.006, 0.005, 0.003));
  std::vector<LinkReport> links = {link_between(0, 15, between(world.truth, 0, 15)),
                                   link_between(1, 15, between(world.truth, 1, 15))};
  const double before = distance_of_last(world);
  close_loops(world.map, world.steps, links);
  EXPECT_EQ(links[0].status, LinkStatus::kAccepted);
  EXPECT_LT(distance_of_last(world), 0.5 * before);
  EXPECT_THAT(world.map.front().world_from_camera, NearPose(SE3{}, 1e-12));
}

// The window moved the last keyframe to where it belongs, and those before it stayed.
TEST(CloseLoops, SharesABendAmongAllSteps) {
  World world = around(motion(0.006, 0.005, 0.003));
  EXPECT_FALSE(is_bent(world.map, world.steps));
  world.map.back().world_from_camera = world.truth.back();
  EXPECT_TRUE(is_bent(world.map, world.steps));
  std::vector<LinkReport> links = {link_between(0, 15, between(world.truth, 0, 15)),
                                   link_between(1, 15, between(world.truth, 1, 15))};
  for (LinkReport& link : links) link.status = LinkStatus::kKnown;
  const auto error_of_last_step = [&world] {
    const SE3 mapped = inverse(world.map[14].world_from_camera) * world.map[15].world_from_camera;
    return (inverse(between(world.truth, 14, 15)) * mapped).translation.norm();
  };
  const double before = error_of_last_step();
  close_loops(world.map, world.steps, links);
  EXPECT_LT(error_of_last_step(), 0.5 * before);
  EXPECT_EQ(links[0].status, LinkStatus::kKnown);
}

TEST(CloseLoops, SwitchesAWrongLinkOffAndMovesNothing) {
  World world = around(SE3{});
  const std::vector<MapKeyframe> before = world.map;
  std::vector<LinkReport> links = {
      link_between(0, 15, between(world.truth, 0, 15) * motion(1, 0, 0))};
  close_loops(world.map, world.steps, links);
  EXPECT_EQ(links[0].status, LinkStatus::kCycle);
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_THAT(world.map[i].world_from_camera, NearPose(before[i].world_from_camera, 1e-6));
}

TEST(JoinSegments, LeavesApartWhatHardlyLooksAlike) {
  World world = around(SE3{});
  for (std::size_t i = 8; i < world.map.size(); ++i) world.map[i].segment = 1;
  std::vector<LinkReport> links = {link_between(0, 8, between(world.truth, 0, 8)),
                                   link_between(1, 9, between(world.truth, 1, 9))};
  for (LinkReport& link : links) link.alike = 0.3;
  join_segments(world.map, links);
  EXPECT_EQ(world.map.back().segment, 1);
  EXPECT_EQ(links[0].status, LinkStatus::kAlone);
}

// Of many links between two rooms that look alike a few are sure by chance.
TEST(JoinSegments, LeavesApartWhatFewOfTheAgreeingLinksAreSureOf) {
  for (const int unsure : {6, 7}) {
    World world = around(SE3{});
    for (std::size_t i = 12; i < world.map.size(); ++i) world.map[i].segment = 1;
    std::vector<LinkReport> links;
    for (std::size_t k = 0; k < 2 + static_cast<std::size_t>(unsure); ++k) {
      const std::size_t to = 12 + k % 4;
      links.push_back(link_between(static_cast<std::int64_t>(k), static_cast<std::int64_t>(to),
                                   between(world.truth, k, to)));
      links.back().alike = k < 2 ? 0.6 : 0.4;
    }
    join_segments(world.map, links);
    EXPECT_EQ(world.map.back().segment, unsure == 6 ? 0 : 1);
  }
}

TEST(JoinSegments, LeavesApartWhatAsManyLinksContradict) {
  World world = around(SE3{});
  for (std::size_t i = 8; i < world.map.size(); ++i) world.map[i].segment = 1;
  std::vector<LinkReport> links;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto id = static_cast<std::int64_t>(i);
    links.push_back(link_between(id, id + 8, between(world.truth, i, i + 8)));
  }
  links[2].from_pose_to = links[2].from_pose_to * motion(0, 0, 1);
  links[3].from_pose_to = links[3].from_pose_to * motion(0, 0, -1);
  join_segments(world.map, links);
  EXPECT_EQ(world.map.back().segment, 1);
}

TEST(CloseLoops, WithoutLinksNothingMoves) {
  World world = around(motion(0.01, 0, 0));
  const SE3 last = world.map.back().world_from_camera;
  std::vector<LinkReport> none;
  close_loops(world.map, world.steps, none);
  EXPECT_EQ(world.map.back().world_from_camera.translation, last.translation);
}

// Keyframes 8 and on are a segment of their own, in a world that is elsewhere.
World in_two_segments(const SE3& elsewhere) {
  World world = around(SE3{});
  for (MapKeyframe& key : world.map)
    if (key.id >= 8) {
      key.segment = 1;
      key.world_from_camera = elsewhere * key.world_from_camera;
    }
  return world;
}

TEST(JoinSegments, MovesASegmentToWhereTwoLinksAgree) {
  World world = in_two_segments(motion(3, -2, 1));
  std::vector<LinkReport> links = {link_between(2, 9, between(world.truth, 2, 9)),
                                   link_between(3, 10, between(world.truth, 3, 10))};
  join_segments(world.map, links);
  for (std::size_t i = 0; i < world.map.size(); ++i) {
    EXPECT_EQ(world.map[i].segment, 0);
    EXPECT_THAT(world.map[i].world_from_camera, NearPose(world.truth[i], 1e-6)) << i;
  }
}

TEST(JoinSegments, OneLinkIsNotEnough) {
  World world = in_two_segments(motion(3, -2, 1));
  std::vector<LinkReport> links = {link_between(2, 9, between(world.truth, 2, 9))};
  join_segments(world.map, links);
  EXPECT_EQ(links[0].status, LinkStatus::kAlone);
  EXPECT_EQ(world.map[9].segment, 1);
}

TEST(JoinSegments, NorAreTwoThatDisagree) {
  World world = in_two_segments(motion(3, -2, 1));
  std::vector<LinkReport> links = {
      link_between(2, 9, between(world.truth, 2, 9)),
      link_between(3, 10, between(world.truth, 3, 10) * motion(0.4, 0, 0))};
  join_segments(world.map, links);
  EXPECT_EQ(links[0].status, LinkStatus::kAlone);
  EXPECT_EQ(links[1].status, LinkStatus::kAlone);
  EXPECT_EQ(world.map[9].segment, 1);
}

}  // namespace
}  // namespace edvo
