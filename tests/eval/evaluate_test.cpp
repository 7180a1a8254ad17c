// SPDX-License-Identifier: MIT
#include "edvo/eval/evaluate.hpp"

#include "edvo/io/trajectory_file.hpp"
#include "support/error_matcher.hpp"
#include "support/paths.hpp"
#include "support/shared_data.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

using test::fails_with;
using test::straight_path;
using test::stretched;
using test::winding_path;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Trajectory delayed(Trajectory path, std::int64_t milliseconds) {
  for (StampedPose& pose : path) pose.stamp.nanoseconds += milliseconds * test::kMillisecond;
  return path;
}

TEST(Evaluate, FindsNoErrorInTheTruth) {
  const Trajectory path = winding_path(60);
  const Evaluation evaluation = evaluate(path, path);
  EXPECT_EQ(evaluation.matches.size(), 60u);
  EXPECT_EQ(evaluation.coverage, 1);
  EXPECT_LT(evaluation.ate.distance.max, 1e-12);
  ASSERT_TRUE(evaluation.rpe);
  EXPECT_LT(evaluation.rpe->translation.max, 1e-12);
  EXPECT_LT(evaluation.drift.distance, 1e-12);
  EXPECT_DOUBLE_EQ(evaluation.seconds, 5.9);
  EXPECT_THAT(evaluation.warnings, IsEmpty());
}

TEST(Evaluate, SaysWhichFileHasQwFirst) {
  const Trajectory path = winding_path(60);
  Trajectory swapped = path;
  for (StampedPose& pose : swapped) {
    const Eigen::Quaterniond q = pose.world_from_camera.rotation;
    pose.world_from_camera.rotation = {q.z(), q.w(), q.x(), q.y()};  // qw qx qy qz read as qx ...
  }
  EXPECT_THAT(evaluate(path, swapped).warnings,
              ElementsAre(HasSubstr("the estimate's quaternions have qw first")));
  EXPECT_THAT(evaluate(swapped, path).warnings,
              ElementsAre(HasSubstr("the ground truth's quaternions have qw first")));
}

TEST(Evaluate, DoesNotSeeWhereTheWorldIsUnlessToldNotToAlign) {
  const Trajectory path = winding_path(60);
  const Trajectory elsewhere = test::moved({.translation = {0, 0, 2}}, path);
  EvalOptions options;
  EXPECT_LT(evaluate(path, elsewhere).ate.distance.max, 1e-12);
  options.alignment = AlignmentKind::kNone;
  EXPECT_NEAR(evaluate(path, elsewhere, options).ate.distance.rmse, 2, 1e-12);
}

TEST(Evaluate, TakesTheScaleIntoRpeAndDrift) {
  const Trajectory path = winding_path(60);
  EvalOptions options;
  options.alignment = AlignmentKind::kSim3;
  const Evaluation evaluation = evaluate(path, stretched(0.25, path), options);
  EXPECT_NEAR(evaluation.ate.truth_from_estimate.scale, 4, 1e-11);
  EXPECT_LT(evaluation.ate.distance.max, 1e-11);
  EXPECT_LT(evaluation.rpe->translation.max, 1e-11);
  EXPECT_LT(evaluation.drift.distance, 1e-11);
}

TEST(Evaluate, MeasuresDriftOnThePathOfTheTruth) {
  const Trajectory path = straight_path(101);  // 10 m
  const Evaluation evaluation = evaluate(path, stretched(0.98, path));
  EXPECT_NEAR(evaluation.drift.path_length, 10, 1e-9);
  EXPECT_NEAR(evaluation.drift.distance, 0.2, 1e-9);
  EXPECT_NEAR(evaluation.drift.percent.value(), 2, 1e-9);
}

TEST(Evaluate, HasNoDriftInPercentOfAStandstill) {
  Trajectory still = straight_path(30);
  for (StampedPose& pose : still) pose.world_from_camera.translation.setZero();
  const Evaluation evaluation = evaluate(still, straight_path(30));
  EXPECT_FALSE(evaluation.drift.percent);
  EXPECT_TRUE(is_finite(evaluation.ate.truth_from_estimate.motion));
}

TEST(Evaluate, CoverageIsOfTheFramesWhereTheyAreKnown) {
  const Trajectory path = winding_path(60);
  const Trajectory part(path.begin(), path.begin() + 30);
  EvalOptions options;
  EXPECT_EQ(evaluate(path, part, options).coverage, 1);
  EXPECT_EQ(evaluate(part, path, options).coverage, 0.5);
  EXPECT_THAT(describe_coverage(options), HasSubstr("estimated poses"));
  options.frames = 60;
  EXPECT_EQ(evaluate(path, part, options).coverage, 0.5);
  EXPECT_THAT(describe_coverage(options), HasSubstr("60 frames"));
}

TEST(Evaluate, NamesBothTimeRangesWhereTheyDoNotMeet) {
  const Trajectory path = winding_path(20);
  for (const Protocol protocol : {Protocol::kTum, Protocol::kEvo})
    EXPECT_TRUE(fails_with(ErrorCode::kEvaluation,
                           {"0 of 20 poses", "0.000 .. 1.900", "1000.000 .. 1001.900", "--offset"},
                           [&] {
                             EvalOptions options;
                             options.association.protocol = protocol;
                             if (protocol == Protocol::kEvo) options.rpe.delta = parse_delta("1f");
                             (void)evaluate(path, delayed(path, 1'000'000), options);
                           }));
}

TEST(Evaluate, NeedsThreePairsToAlignAndOneOtherwise) {
  const Trajectory path = winding_path(60);
  const Trajectory one(path.begin(), path.begin() + 1);
  EXPECT_TRUE(fails_with(ErrorCode::kEvaluation, {"1 of 1 poses", "at least 3"},
                         [&] { (void)evaluate(path, one); }));
  EXPECT_TRUE(fails_with(ErrorCode::kEvaluation, {"nothing"}, [&] { (void)evaluate(path, {}); }));
  EvalOptions options;
  options.alignment = AlignmentKind::kNone;
  const Evaluation evaluation = evaluate(path, one, options);
  EXPECT_EQ(evaluation.ate.errors.size(), 1u);
  EXPECT_FALSE(evaluation.rpe);
  EXPECT_THAT(evaluation.warnings, testing::ElementsAre(HasSubstr("no RPE")));
}

TEST(Evaluate, WarnsWhereRpeIsTooGood) {
  const Trajectory sparse = straight_path(10, 5000);
  EXPECT_THAT(evaluate(sparse, sparse).warnings, testing::ElementsAre(HasSubstr("pair")));
}

TEST(Evaluate, RefusesImpossibleOptions) {
  const Trajectory path = winding_path(20);
  const auto with = [&](auto change) {
    return [&path, change] {
      EvalOptions options;
      change(options);
      (void)evaluate(path, path, options);
    };
  };
  EXPECT_TRUE(fails_with(ErrorCode::kUsage, {"max-diff"},
                         with([](EvalOptions& o) { o.association.max_difference = 0; })));
  EXPECT_TRUE(fails_with(ErrorCode::kUsage, {"max-diff"},
                         with([](EvalOptions& o) { o.association.max_difference = NAN; })));
  EXPECT_TRUE(fails_with(ErrorCode::kUsage, {"max-diff"},
                         with([](EvalOptions& o) { o.association.max_difference = 5; })));
  EXPECT_TRUE(fails_with(ErrorCode::kUsage, {"offset"},
                         with([](EvalOptions& o) { o.association.offset = INFINITY; })));
  EXPECT_TRUE(fails_with(ErrorCode::kUsage, {"max-pairs"},
                         with([](EvalOptions& o) { o.rpe.max_pairs = -1; })));
  EXPECT_TRUE(
      fails_with(ErrorCode::kUsage, {"frames"}, with([](EvalOptions& o) { o.frames = -1; })));
}

TEST(Evaluate, SaysItsProtocol) {
  EvalOptions options;
  EXPECT_EQ(describe_protocol(options),
            "TUM protocol: ATE rmse over pairs < 0.02 s apart, SE(3)-aligned; "
            "RPE rmse over fixed delta 1s");
  options.association = {.protocol = Protocol::kEvo, .max_difference = 0.01, .offset = 0.5};
  options.alignment = AlignmentKind::kNone;
  options.rpe.delta = parse_delta("1f");
  EXPECT_EQ(describe_protocol(options),
            "evo protocol: ATE rmse over pairs <= 0.01 s apart, offset 0.5 s, not aligned; "
            "RPE rmse over fixed delta 1f");
}

// Trajectories of other systems on fr1/xyz, with the figures known for them.
TEST(Evaluate, AgreesOnThePeers) {
  const std::filesystem::path data = test::shared_data();
  EDVO_REQUIRE_SHARED(data / "peers/fr1_xyz");
  EDVO_REQUIRE_SHARED(data / "tum/rgbd_dataset_freiburg1_xyz/groundtruth.txt");
  const Trajectory truth =
      read_trajectory(data / "tum/rgbd_dataset_freiburg1_xyz/groundtruth.txt").trajectory;
  struct Row {
    const char* name;
    double ate, rpe_translation, rpe_rotation;  // [m], [m/s], [deg/s]
  };
  for (const Row& row :
       {Row{"orb_slam2_no_loop", 0.0100, 0.0160, 1.012},
        Row{"opencv_rgbd_icp", 0.0321, 0.0176, 0.963}, Row{"edge_direct_vo", 0.0574, 0.0245, 1.468},
        Row{"revo", 0.0573, 0.0235, 1.390}, Row{"reslam", 0.0190, 0.0229, 1.399},
        Row{"dvo_keyframe", 0.0256, 0.0234, 1.418}}) {
    const auto file = data / "peers/fr1_xyz" / (std::string(row.name) + ".txt");
    const Evaluation evaluation = evaluate(truth, read_trajectory(file).trajectory);
    EXPECT_NEAR(evaluation.ate.distance.rmse, row.ate, 5.1e-5) << row.name;
    ASSERT_TRUE(evaluation.rpe);
    EXPECT_NEAR(evaluation.rpe->translation.rmse, row.rpe_translation, 5.1e-5) << row.name;
    EXPECT_NEAR(evaluation.rpe->rotation.rmse, row.rpe_rotation, 5.1e-4) << row.name;
  }
}

}  // namespace
}  // namespace edvo
