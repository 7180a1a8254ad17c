// SPDX-License-Identifier: MIT
#include "edvo/run/evaluation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

namespace edvo {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kPoses = 60;

// A half circle of the given radius [m], a pose every so many seconds.
Trajectory half_circle(double radius, double seconds) {
  Trajectory poses;
  for (int i = 0; i < kPoses; ++i) {
    const double angle = M_PI * i / kPoses;
    poses.push_back(
        {.stamp = {.nanoseconds = std::llround(1e9 * seconds * i), .decimals = 9},
         .world_from_camera = {.translation = {radius * std::cos(angle), radius * std::sin(angle),
                                               0.1 * radius * angle}}});
  }
  return poses;
}

RunEvaluation evaluated(const Trajectory& truth, const Trajectory& estimate) {
  RunOutcome outcome;
  outcome.counts.tracked = kPoses;
  outcome.trajectory = outcome.online = estimate;
  return evaluate_run({.source = "truth", .trajectory = truth}, outcome);
}

SourceInfo source_with(double units_per_metre) {
  SourceInfo source;
  source.depth_scale = units_per_metre;
  source.depth_origin = "assumed";
  return source;
}

TEST(RunEvaluation, TellsTheScaleOfAWrongDepthScale) {
  // Millimetres read as if 5000 were a metre.
  const RunEvaluation evaluation = evaluated(half_circle(1, 0.1), half_circle(0.2, 0.1));
  EXPECT_NEAR(evaluation.scale, 5, 1e-9);
  EXPECT_NEAR(evaluation.scaled_ate, 0, 1e-9);
  const auto warning = warn_of_scale(evaluation, source_with(5000));
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, AllOf(HasSubstr("scaled by 5"), HasSubstr("(assumed; "),
                              HasSubstr("--depth-scale 1000")));
}

TEST(RunEvaluation, DoesNotAdviseTheScaleThatWasUsed) {
  const RunEvaluation evaluation = evaluated(half_circle(1, 0.1), half_circle(0.96, 0.1));
  const auto warning = warn_of_scale(evaluation, source_with(5000));
  ASSERT_TRUE(warning);
  EXPECT_THAT(*warning, HasSubstr("--depth-scale 4800"));
}

TEST(RunEvaluation, ARightScaleIsNotWarnedOf) {
  const RunEvaluation evaluation = evaluated(half_circle(1, 0.1), half_circle(0.99, 0.1));
  EXPECT_FALSE(warn_of_scale(evaluation, source_with(5000)));
}

TEST(RunEvaluation, AnErrorThatNoScaleExplainsIsNotBlamedOnIt) {
  Trajectory bent = half_circle(0.8, 0.1);
  for (StampedPose& pose : bent) pose.world_from_camera.translation.y() = 0;
  const RunEvaluation evaluation = evaluated(half_circle(1, 0.1), bent);
  EXPECT_GT(std::abs(evaluation.scale - 1), kScaleTolerance);
  EXPECT_FALSE(warn_of_scale(evaluation, source_with(5000)));
}

TEST(RunEvaluation, DepthInMetresHasNoScaleToMend) {
  const RunEvaluation evaluation = evaluated(half_circle(1, 0.1), half_circle(0.2, 0.1));
  EXPECT_FALSE(warn_of_scale(evaluation, source_with(0)));
}

TEST(RunEvaluation, HasNoRpeWhereAllPairsAreVoidAndWarns) {
  // Milliseconds taken for seconds: no pose is 1 s after another.
  const RunEvaluation evaluation = evaluated(half_circle(1, 33), half_circle(1, 33));
  EXPECT_EQ(evaluation.final_poses.rpe_pairs, 0);
  EXPECT_THAT(evaluation.warnings, Contains(HasSubstr("join a pose with itself")));
  EXPECT_EQ(evaluation.final_poses.ate_pairs, kPoses);
}

TEST(RunEvaluation, HasRpeAndNoWarningAtTheUsualRate) {
  const RunEvaluation evaluation = evaluated(half_circle(1, 0.1), half_circle(1, 0.1));
  EXPECT_GT(evaluation.final_poses.rpe_pairs, 0);
  EXPECT_THAT(evaluation.warnings, IsEmpty());
}

}  // namespace
}  // namespace edvo
