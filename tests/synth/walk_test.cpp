// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/synth/rays.hpp"
#include "edvo/synth/render.hpp"
#include "edvo/synth/sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace edvo::synth {
namespace {

constexpr std::array kWorlds = {SceneName::kFlat, SceneName::kPosters, SceneName::kTwins,
                                SceneName::kDeskRows};

TEST(Rounds, AreAsLongAsAsked) {
  for (const SceneName name : kWorlds) {
    const Scene scene = make_scene(name, 0);
    for (const double length : {20.0, 50.0, 100.0, 250.0})
      for (const std::uint64_t seed : {1, 2, 3})
        EXPECT_NEAR(path_length(make_rounds(scene, length, seed)), length, 0.01 * length)
            << name_of(name) << seed;
  }
}

TEST(Rounds, EndWhereTheyBegan) {
  const Scene scene = make_scene(SceneName::kFlat, 0);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Trajectory walk = make_rounds(scene, 60, seed);
    const SE3 end = inverse(walk.front().world_from_camera) * walk.back().world_from_camera;
    EXPECT_LT(end.translation.norm(), 0.2) << seed;
    EXPECT_LT(rotation_angle(end), 0.35) << seed;
  }
}

TEST(Rounds, StayClearOfWallsAndFurniture) {
  for (const SceneName name : kWorlds)
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Scene scene = make_scene(name, seed);
      const Trajectory walk = make_rounds(scene, 100, seed);
      for (std::size_t i = 0; i < walk.size(); i += 5) {
        const Eigen::Vector3d& eye = walk[i].world_from_camera.translation;
        ASSERT_GT(clearance(scene, eye), 0.2) << name_of(name) << seed << ": " << eye.transpose();
      }
    }
}

TEST(Rounds, WalkAndTurnLikeAPerson) {
  constexpr double kFastest = 1.0, kFastestTurn = 1.2;  // [m/s], [rad/s]
  const Trajectory walk = make_rounds(make_scene(SceneName::kFlat, 1), 60, 1);
  for (std::size_t i = 1; i < walk.size(); ++i) {
    const double seconds = seconds_between(walk[i - 1].stamp, walk[i].stamp);
    const SE3 step = inverse(walk[i - 1].world_from_camera) * walk[i].world_from_camera;
    ASSERT_LT(step.translation.norm() / seconds, kFastest) << i;
    ASSERT_LT(rotation_angle(step) / seconds, kFastestTurn) << i;
  }
  EXPECT_GT(path_length(walk) / seconds_between(walk.front().stamp, walk.back().stamp), 0.6);
}

TEST(Rounds, EnterRoomsAgain) {
  const Scene scene = make_scene(SceneName::kFlat, 0);
  const Trajectory walk = make_rounds(scene, 250, 1);
  int visits = 0;
  for (const auto& round : scene.walk.rounds) {
    bool is_inside = false;
    for (const StampedPose& pose : walk) {
      const Eigen::Vector3d& eye = pose.world_from_camera.translation;
      const bool inside = (eye.head<2>() - round[1].head<2>()).norm() < 0.8;
      if (inside && !is_inside) ++visits;
      is_inside = inside;
    }
  }
  EXPECT_GT(visits, 2 * static_cast<int>(scene.walk.rounds.size()));
}

TEST(Rounds, NeedASceneToWalkThrough) {
  EXPECT_THROW((void)make_rounds(make_scene(SceneName::kOffice, 0), 10, 0), Error);
}

TEST(Rounds, OfALengthMakeAsManyFramesAsItTakes) {
  const SyntheticSequence sequence = make_sequence({.scene = SceneName::kFlat,
                                                    .path = PathName::kRounds,
                                                    .frames = 3,
                                                    .path_length = 20,
                                                    .rate = 10,
                                                    .sensor = {}});
  EXPECT_GT(frame_count(sequence), 200);
  EXPECT_NEAR(path_length(ground_truth(sequence)), 20, 0.5);
  const SyntheticSequence few = make_sequence(
      {.scene = SceneName::kFlat, .path = PathName::kRounds, .frames = 30, .sensor = {}});
  EXPECT_EQ(frame_count(few), 30);
}

// What a camera sees that stands in the same way in each of two rooms.
std::array<Render, 2> views_of_two_rooms(SceneName name) {
  const Scene scene = make_scene(name, 5);
  const Camera camera{.fx = 60, .fy = 60, .cx = 31.5, .cy = 23.5, .width = 64, .height = 48};
  const auto render_in = [&](const std::vector<Eigen::Vector3d>& round) {
    const Eigen::Vector3d height{0, 0, 1.3};
    const SE3 pose = look_at(round[4] + height, round[3] + height - Eigen::Vector3d{0, 0, 0.1});
    return render(scene, 0, pose, make_rays({camera, {}}), 1);
  };
  return {render_in(scene.walk.rounds[0]), render_in(scene.walk.rounds[3])};
}

double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * a.channels());
}

TEST(Flat, TwinsLookTheSame) {
  const auto [a, b] = views_of_two_rooms(SceneName::kTwins);
  EXPECT_LT(mean_difference(a.bgr, b.bgr), 0.5);
  EXPECT_LT(mean_difference(a.depth, b.depth), 1e-3);
}

TEST(Flat, PostersAloneTellRoomsApart) {
  const auto [a, b] = views_of_two_rooms(SceneName::kPosters);
  EXPECT_GT(mean_difference(a.bgr, b.bgr), 0.5);
  EXPECT_LT(mean_difference(a.depth, b.depth), 1e-3);
}

TEST(Flat, RoomsDiffer) {
  const auto [a, b] = views_of_two_rooms(SceneName::kFlat);
  EXPECT_GT(mean_difference(a.bgr, b.bgr), 5);
  EXPECT_GT(mean_difference(a.depth, b.depth), 0.02);
}

}  // namespace
}  // namespace edvo::synth
