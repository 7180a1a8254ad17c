// SPDX-License-Identifier: MIT
#include "edvo/report/worst_frames.hpp"

#include "report/sample_run.hpp"

#include <gmock/gmock.h>

#include <numeric>

namespace edvo {
namespace {

using test::sample_run;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::vector<std::int64_t> all_frames(std::int64_t count) {
  std::vector<std::int64_t> frames(static_cast<std::size_t>(count));
  std::iota(frames.begin(), frames.end(), 0);
  return frames;
}

TEST(WorstFrames, AreThoseOfTheLargestRelativeErrorWhereThereIsGroundTruth) {
  test::SampleRun run = sample_run(300);
  std::vector<double>& errors = run.outcome.evaluation->final_poses.rpe_translation_curve.values;
  errors[60] = 0.5;
  errors[62] = 0.49;  // the same moment
  errors[200] = 0.7;
  run.log.frames[100].rms = 90;
  const auto worst = choose_worst_frames(run.log, run.outcome.evaluation, all_frames(300));
  ASSERT_EQ(worst.size(), kWorstFrames);
  EXPECT_EQ(worst[0].frame, 200);
  EXPECT_THAT(worst[0].reason, HasSubstr("relative error 70.00 cm/s"));
  EXPECT_EQ(worst[1].frame, 60);
  EXPECT_NEAR(worst[1].seconds, 2, 1e-3);
  for (std::size_t i = 2; i < worst.size(); ++i) EXPECT_NE(worst[i].frame, 62);
}

TEST(WorstFrames, AreThoseOfTheLargestResidualsWhereThereIsNone) {
  test::SampleRun run = sample_run(300);
  for (FrameRecord& frame : run.log.frames) frame.rms = 4;
  run.log.frames[100].rms = 12;
  const auto worst = choose_worst_frames(run.log, {}, all_frames(300));
  ASSERT_FALSE(worst.empty());
  EXPECT_EQ(worst[0].frame, 100);
  EXPECT_THAT(worst[0].reason,
              AllOf(HasSubstr("tracked"), HasSubstr("rms 12.0 (usual 4.0)"), HasSubstr("inliers")));
}

TEST(WorstFrames, BeginWithTheLongestLossAndItsCause) {
  test::SampleRun run = sample_run(800);  // lost: 391 to 399, 791 to 799
  run.log.frames[400].status = FrameStatus::kLost;
  run.log.frames[391].loss_cause = LossCause::kUnlike;
  const auto worst = choose_worst_frames(run.log, run.outcome.evaluation, all_frames(800));
  ASSERT_GE(worst.size(), 1u);
  EXPECT_EQ(worst[0].frame, 391);
  EXPECT_EQ(worst[0].reason, "lost for 10 frames: " + explain(LossCause::kUnlike));
}

TEST(WorstFrames, AreChosenAmongTheCandidatesOnly) {
  const test::SampleRun run = sample_run(300);
  const std::vector<std::int64_t> candidates = {30, 150, 12345};
  const auto worst = choose_worst_frames(run.log, run.outcome.evaluation, candidates);
  ASSERT_EQ(worst.size(), 2u);
  for (const WorstFrame& frame : worst) EXPECT_TRUE(frame.frame == 30 || frame.frame == 150);
}

}  // namespace
}  // namespace edvo
