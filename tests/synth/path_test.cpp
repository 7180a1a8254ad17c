// SPDX-License-Identifier: MIT
#include "edvo/synth/path.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/random.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/synth/rays.hpp"
#include "support/matchers.hpp"
#include "support/shared_data.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace edvo::synth {
namespace {

using test::NearPose;

constexpr double kFrame = 1.0 / 30;  // [s]

Path path_in(SceneName scene, PathName name, std::uint64_t seed = 0) {
  return make_path(name, make_scene(scene, seed).stage, seed);
}

double length_of(const Path& path, double seconds) {  // [m]
  double length = 0;
  for (double t = 0; t < seconds; t += kFrame)
    length += (pose_at(path, t + kFrame).translation - pose_at(path, t).translation).norm();
  return length;
}

TEST(Path, DemoIsAtLeastFiveMetresLongInTenSeconds) {
  for (const auto& [scene, name] : EnumNames<SceneName>::names)
    for (const std::uint64_t seed : {0, 1, 2}) {
      const double length = length_of(path_in(scene, PathName::kDemo, seed), 10);
      EXPECT_GE(length, 5.0) << name << seed;
      EXPECT_LE(length, 6.0) << name << seed;
    }
}

TEST(Path, DemoMovesLikeAHand) {
  constexpr double kFastest = 1.6, kFastestTurn = 2.0;     // [m/s], [rad/s]
  constexpr double kHardestPush = 15, kHardestTwist = 15;  // [m/s^2], [rad/s^2]
  for (const auto& [scene, name] : EnumNames<SceneName>::names) {
    const Path path = path_in(scene, PathName::kDemo);
    Vector6d before = Vector6d::Zero();
    for (int i = 0; i < 300; ++i) {
      const Vector6d rate =
          log(inverse(pose_at(path, i * kFrame)) * pose_at(path, (i + 1) * kFrame)) / kFrame;
      EXPECT_LT(rate.head<3>().norm(), kFastest) << name << i;
      EXPECT_LT(rate.tail<3>().norm(), kFastestTurn) << name << i;
      if (i > 0) {
        EXPECT_LT((rate - before).head<3>().norm() / kFrame, kHardestPush) << name << i;
        EXPECT_LT((rate - before).tail<3>().norm() / kFrame, kHardestTwist) << name << i;
      }
      before = rate;
    }
  }
}

TEST(Path, DemoTurnsAndMovesAboutEveryAxis) {
  const Path path = path_in(SceneName::kOffice, PathName::kDemo);
  Vector6d most = Vector6d::Zero();
  for (double t = 0; t < 10; t += 0.1)
    most = most.cwiseMax(log(inverse(pose_at(path, 0)) * pose_at(path, t)).cwiseAbs());
  EXPECT_GT(most.head<3>().minCoeff(), 0.1);
  EXPECT_GT(most.tail<3>().minCoeff(), 0.05);
}

TEST(Path, NamedPathsStayClearOfFurniture) {
  for (const auto& [scene_name, scene_text] : EnumNames<SceneName>::names) {
    const Scene scene = make_scene(scene_name, 0);
    for (const auto& [name, text] : EnumNames<PathName>::names) {
      const Path path = make_path(name, scene.stage, 0);
      for (double t = 0; t < 20; t += 0.1)
        ASSERT_GT(clearance(scene, pose_at(path, t).translation), 0.2)
            << scene_text << " " << text << " " << t;
    }
  }
}

TEST(Path, PureRotationTurnsSixtyDegreesPerSecondOnTheSpot) {
  const Path path = path_in(SceneName::kDesk, PathName::kPureRotation);
  const SE3 second = inverse(pose_at(path, 1)) * pose_at(path, 2);
  EXPECT_LT((pose_at(path, 1).translation - pose_at(path, 0).translation).norm(), 1e-12);
  // About the vertical, seen from a camera that looks a little down.
  const Path level = make_path(PathName::kPureRotation, {.eye = {0, 0, 1}, .target = {0, 1, 1}}, 0);
  const SE3 turn = inverse(pose_at(level, 1)) * pose_at(level, 2);
  EXPECT_NEAR(rotation_angle(turn) * 180 / std::numbers::pi, 60, 1e-9);
  EXPECT_NEAR(rotation_angle(second) * 180 / std::numbers::pi, 60, 1e-6);
}

TEST(Path, StillDoesNotMove) {
  const Path path = path_in(SceneName::kDesk, PathName::kStill);
  EXPECT_THAT(pose_at(path, 7), NearPose(pose_at(path, 0), 1e-12));
}

TEST(Path, XyzMovesAlongOneAxisAtATime) {
  const Path path = path_in(SceneName::kDesk, PathName::kXyz);
  constexpr double kTremor = 0.006;  // [m]
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d most = Eigen::Vector3d::Zero();
    for (double t = 3 * axis; t < 3 * axis + 3; t += 0.05)
      most = most.cwiseMax((pose_at(path, t).translation - path.stage.eye).cwiseAbs());
    for (int other = 0; other < 3; ++other)
      EXPECT_TRUE(other == axis ? most[other] > 0.1 : most[other] < kTremor) << axis << other;
  }
}

TEST(Path, LookAtPutsTheTargetOnTheOpticalAxis) {
  const Eigen::Vector3d eye{1, 2, 1.5}, target{-1, 0.5, 0.7};
  const Eigen::Vector3d seen = inverse(look_at(eye, target)) * target;
  EXPECT_LT(seen.head<2>().norm(), 1e-12);
  EXPECT_NEAR(seen.z(), (target - eye).norm(), 1e-12);
  EXPECT_LT((look_at(eye, target).rotation * Eigen::Vector3d::UnitY()).z(), -0.8);  // y is down
}

Trajectory line(const Eigen::Vector3d& step, int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i)
    trajectory.push_back({.stamp = stamp_from_seconds(100 + 0.1 * i),
                          .world_from_camera = {.translation = i * step}});
  return trajectory;
}

TEST(Path, RecordedPosesAreMetAtTheirStampsAndBlendBetween) {
  const Path path{.stage = {}, .recorded = line({0.2, 0, 0}, 5)};
  EXPECT_NEAR(pose_at(path, 0.2).translation.x(), 0.4, 1e-9);
  EXPECT_NEAR(pose_at(path, 0.25).translation.x(), 0.5, 1e-9);
  EXPECT_NEAR(pose_at(path, -1).translation.x(), 0, 1e-12);
  EXPECT_NEAR(pose_at(path, 99).translation.x(), 0.8, 1e-12);
}

TEST(Path, JitterOfAMeasuredMotionIsSmoothedAwayAndTheMotionStays) {
  const auto swing = [](double seconds) {  // 2 Hz, as a hand's
    Vector6d xi;
    xi << 0.02, 0.01, 0.03, 0.02, 0.03, 0.01;
    return exp(std::sin(4 * std::numbers::pi * seconds) * xi);
  };
  constexpr int kPoses = 600;
  constexpr double kJitter = 5e-4, kRate = 300;  // [m], [rad]; [Hz]
  Random random{7};
  Trajectory recorded;
  for (int i = 0; i < kPoses; ++i) {
    Vector6d jitter;
    for (int k = 0; k < 6; ++k) jitter[k] = kJitter * static_cast<double>(random.normal());
    recorded.push_back({.stamp = stamp_from_seconds(100 + i / kRate),
                        .world_from_camera = swing(i / kRate) * exp(jitter)});
  }
  const Trajectory smooth = without_jitter(recorded);
  ASSERT_EQ(smooth.size(), recorded.size());
  double squares = 0;
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    EXPECT_EQ(smooth[i].stamp, recorded[i].stamp);
    const SE3 truth = swing(static_cast<double>(i) / kRate);
    squares += log(inverse(truth) * smooth[i].world_from_camera).squaredNorm() / 6;
  }
  EXPECT_LT(std::sqrt(squares / kPoses), 0.5 * kJitter);

  const Trajectory sparse = line({0.2, 0, 0}, 5), same = without_jitter(sparse);
  for (std::size_t i = 0; i < sparse.size(); ++i)
    EXPECT_EQ(same[i].world_from_camera.translation, sparse[i].world_from_camera.translation);
}

TEST(Path, ATrajectoryOfACameraWorldIsStoodUpright) {
  // World = first camera: z forward, y down, as most odometries write it.
  const Scene scene = make_scene(SceneName::kOffice, 0);
  const Trajectory fitted = fit_into(scene, line({0.05, 0, 0.05}, 20));
  for (const StampedPose& pose : fitted)
    EXPECT_LT((pose.world_from_camera.rotation * Eigen::Vector3d::UnitY()).z(), -0.99);
}

TEST(Path, ATrajectoryTooWideForTheRoomIsShrunk) {
  const Scene scene = make_scene(SceneName::kOffice, 0);
  const Trajectory recorded = line({1, 0, 0}, 20), fitted = fit_into(scene, recorded);
  for (const StampedPose& pose : fitted)
    EXPECT_GT(clearance(scene, pose.world_from_camera.translation), 0.2);
  ASSERT_EQ(fitted.size(), recorded.size());
  EXPECT_EQ(fitted[7].stamp, recorded[7].stamp);
}

TEST(Path, ATrajectoryOfOnePoseIsRefused) {
  EXPECT_THROW((void)fit_into(make_scene(SceneName::kWall, 0), line({0, 0, 0}, 1)), Error);
}

TEST(Path, RecordedHandMotionStaysInTheRoomAndSeesSurfaces) {
  const auto folder = test::shared_data() / "trajectories";
  EDVO_REQUIRE_SHARED(folder);
  const Scene scene = make_scene(SceneName::kLivingRoom, 0);
  for (const char* name : {"360_hemisphere", "coke", "dishes"}) {
    const auto file = folder / ("rgbd_dataset_freiburg2_" + std::string(name) + "-groundtruth.txt");
    EDVO_REQUIRE_SHARED(file);
    const Trajectory recorded = read_trajectory(file).trajectory;
    const Path path{.stage = {}, .recorded = fit_into(scene, recorded)};
    int views = 0, useful = 0;
    for (double t = 0; t < 80; t += 0.5, ++views) {
      const SE3 pose = pose_at(path, t);
      EXPECT_GT(clearance(scene, pose.translation), 0.25) << name << " " << t;
      const std::vector<SolidInView> solids = view_from(scene, 0, pose);
      const float depth = cast(solids, nearest_first(solids), RayPack{})[0].depth;
      if (depth > 0.5F && depth < 4) ++useful;
    }
    EXPECT_GT(useful, 0.8 * views) << name;
  }
}

}  // namespace
}  // namespace edvo::synth
