// SPDX-License-Identifier: MIT
#include "edvo/eval/rpe.hpp"

#include "support/error_matcher.hpp"
#include "support/paths.hpp"

#include <gmock/gmock.h>

#include <numbers>

namespace edvo {
namespace {

using test::straight_path;
using test::stretched;
using test::winding_path;

constexpr double kExact = 1e-12;

std::optional<Rpe> rpe(const Trajectory& truth, const Trajectory& estimate, const char* delta,
                       int max_pairs = 10000, std::uint64_t seed = 0) {
  return relative_pose_error(truth, estimate, {},
                             {.delta = parse_delta(delta), .max_pairs = max_pairs, .seed = seed});
}

TEST(Delta, IsReadAndWrittenAlike) {
  for (const char* text : {"1s", "0.5s", "30f", "2m", "0.1rad", "10deg", "all"})
    EXPECT_EQ(to_string(parse_delta(text)), text);
}

TEST(Delta, RefusesWhatIsNone) {
  for (const char* text : {"", "1", "s", "-1s", "0s", "nans", "infs", "1 s", "1km", "1e400s"})
    EXPECT_TRUE(test::fails_with(ErrorCode::kUsage, {std::string("\"") + text + "\"", "30f"},
                                 [&] { (void)parse_delta(text); }));
}

TEST(Delta, SaysWhatAnErrorIsOver) {
  EXPECT_EQ(per_delta(parse_delta("1s")), "/s");
  EXPECT_EQ(per_delta(parse_delta("1f")), "/frame");
  EXPECT_EQ(per_delta(parse_delta("30f")), " per 30 frames");
  EXPECT_EQ(per_delta(parse_delta("2.5s")), " per 2.5 s");
  EXPECT_EQ(per_delta(parse_delta("all")), " over all pairs");
}

TEST(Rpe, OfATrajectoryWithItselfIsZero) {
  const Trajectory path = winding_path(50);
  for (const char* delta : {"1s", "1f", "30f", "1m", "0.2rad", "10deg", "all"}) {
    const auto result = rpe(path, path, delta);
    ASSERT_TRUE(result) << delta;
    EXPECT_LT(result->translation.max, kExact) << delta;
    EXPECT_LT(result->rotation.max, 1e-10) << delta;
  }
}

TEST(Rpe, DoesNotSeeWhereTheWorldIs) {
  const Trajectory path = winding_path(50);
  Vector6d xi;
  xi << 1, 2, 3, 1, -1, 2;
  const auto result = rpe(path, test::moved(exp(xi), path), "1s");
  ASSERT_TRUE(result);
  EXPECT_LT(result->translation.max, 1e-11);
}

TEST(Rpe, MeasuresDriftPerSecond) {
  const Trajectory path = straight_path(50);  // 1 m/s
  const auto result = rpe(path, stretched(1.01, path), "1s");
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->translation.rmse, 0.01, kExact);
  EXPECT_NEAR(result->rotation.rmse, 0, kExact);
  EXPECT_NEAR(rpe(path, stretched(1.01, path), "2s")->translation.rmse, 0.02, kExact);
  EXPECT_NEAR(rpe(path, stretched(1.01, path), "5f")->translation.rmse, 0.005, kExact);
}

TEST(Rpe, MeasuresRotationInDegrees) {
  Trajectory turning = straight_path(50);
  const Trajectory path = turning;
  for (std::size_t i = 0; i < turning.size(); ++i) {
    const double angle = 0.01 * static_cast<double>(i);  // 0.1 rad/s
    turning[i].world_from_camera.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ());
  }
  const auto result = rpe(path, turning, "1s");
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->rotation.rmse, 0.1 * 180 / std::numbers::pi, 1e-9);
}

TEST(Rpe, LeavesOutPairsThatEndOnTheLastPose) {
  const Trajectory path = straight_path(21);  // 0 .. 2 s
  const auto result = rpe(path, path, "1s");
  ASSERT_TRUE(result);
  // From 0 s to 0.9 s. From 1.0 s on the last pose is the nearest one.
  EXPECT_EQ(result->errors.size(), 10u);
  EXPECT_EQ(result->errors.back().to, path[19].stamp);
}

TEST(Rpe, GoesByMetresAlongTheEstimate) {
  const Trajectory path = straight_path(21);
  const auto result = rpe(path, stretched(2, path), "1m");
  ASSERT_TRUE(result);
  EXPECT_NEAR(seconds_between(result->errors[0].from, result->errors[0].to), 0.5, kExact);
}

TEST(Rpe, LeavesOutPosesWithoutGroundTruth) {
  Trajectory truth = straight_path(61);
  const Trajectory estimate = truth;
  truth.erase(truth.begin() + 20, truth.begin() + 40);  // nothing from 2.0 s to 3.9 s
  const auto result = rpe(truth, estimate, "1s");
  ASSERT_TRUE(result);
  // Ground truth may be up to twice its interval away, 0.2 s.
  const auto in_the_hole = [](const Stamp& stamp) {
    return stamp > test::stamp_at(2100) && stamp < test::stamp_at(3800);
  };
  for (const RpeError& error : result->errors)
    EXPECT_FALSE(in_the_hole(error.from) || in_the_hole(error.to)) << to_string(error.from);
}

TEST(Rpe, IsEmptyWhereNoTwoPosesAreDeltaApart) {
  const Trajectory path = straight_path(5);
  EXPECT_FALSE(rpe(path, path, "10s"));
  EXPECT_FALSE(rpe(path, Trajectory(1), "1s"));
  EXPECT_FALSE(rpe({}, path, "1s"));
}

TEST(Rpe, CountsPairsOfAPoseWithItself) {
  const Trajectory path = straight_path(10, 5000);  // a pose each 5 s
  const auto result = rpe(path, path, "1s");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->void_pairs, result->errors.size());
}

TEST(Rpe, SamplesManyPairsTheSameWayForTheSameSeed) {
  const Trajectory path = winding_path(300);
  const Trajectory estimate = stretched(1.1, path);
  for (const char* delta : {"all", "1s"}) {
    const auto first = rpe(path, estimate, delta, 100, 7);
    const auto again = rpe(path, estimate, delta, 100, 7);
    const auto other = rpe(path, estimate, delta, 100, 8);
    EXPECT_EQ(first->errors.size(), 100u);
    EXPECT_EQ(first->translation.rmse, again->translation.rmse);
    EXPECT_NE(first->translation.rmse, other->translation.rmse);
  }
  EXPECT_EQ(rpe(path, estimate, "all", 0)->errors.size(), 300u * 300u);
}

TEST(Rpe, EvoTakesPairsThatDoNotOverlap) {
  const Trajectory path = straight_path(11);
  const auto result =
      relative_pose_error(path, path, {.protocol = Protocol::kEvo}, {.delta = parse_delta("3f")});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->errors.size(), 3u);
}

TEST(Rpe, EvoKnowsFramesOnly) {
  const Trajectory path = straight_path(11);
  for (const char* delta : {"1s", "1m", "2.5f", "all"})
    EXPECT_TRUE(test::fails_with(ErrorCode::kUsage, {delta}, [&] {
      (void)relative_pose_error(path, path, {.protocol = Protocol::kEvo},
                                {.delta = parse_delta(delta)});
    }));
}

}  // namespace
}  // namespace edvo
