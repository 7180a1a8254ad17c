// SPDX-License-Identifier: MIT
#include "edvo/report/summary.hpp"

#include "report/sample_run.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace edvo {
namespace {

using nlohmann::json;
using test::sample_description;
using test::sample_run;

TEST(Summary, CountsFramesAndLostEvents) {
  const test::SampleRun run = sample_run(800);  // lost: 391..399, 791..799
  const RunSummary summary = summarize(sample_description(), run.log, run.outcome);
  EXPECT_EQ(summary.counts.tracked, 782);
  EXPECT_EQ(summary.counts.lost, 18);
  EXPECT_EQ(summary.lost_events, 2);
  EXPECT_EQ(summary.keyframes, 40);
  EXPECT_DOUBLE_EQ(summary.coverage, 782.0 / 800);
}

TEST(Summary, CountsSkippedFramesAgainstTheCoverage) {
  test::SampleRun run = sample_run(9);
  run.outcome.counts.skipped = 1;
  run.log.skipped = {{.index = 9, .stamp = "1", .reason = "truncated"}};
  const RunSummary summary = summarize(sample_description(), run.log, run.outcome);
  EXPECT_DOUBLE_EQ(summary.coverage, 0.9);
  EXPECT_EQ(json::parse(to_json(summary))["frames"]["skipped"], 1);
}

TEST(Summary, HasAllThatIsNeededToRepeatTheRun) {
  const test::SampleRun run = sample_run(50);
  const json summary = json::parse(to_json(summarize(sample_description(), run.log, run.outcome)));
  EXPECT_EQ(summary["schema_version"], kSchemaVersion);
  EXPECT_EQ(summary["command"], sample_description().command);
  EXPECT_EQ(summary["config_hash"], config_hash(sample_description().config));
  EXPECT_EQ(summary["camera"]["fx"], 517.3);
  EXPECT_EQ(summary["depth"]["units_per_metre"], 5000);
  EXPECT_EQ(summary["evaluation"]["final"]["ate_rmse_m"], 0.0123);
  EXPECT_FALSE(summary["evaluation"]["protocol"].get<std::string>().empty());
  for (const char* key : {"edvo_version", "machine", "seed", "ms", "peak_memory_mb", "warnings"})
    EXPECT_TRUE(summary.contains(key)) << key;
}

TEST(Summary, HasNoUnitsOfDepthWhereFramesAreInMetres) {
  const test::SampleRun run = sample_run(50);
  RunDescription description = sample_description();
  description.depth_scale = 0;
  const json summary = json::parse(to_json(summarize(description, run.log, run.outcome)));
  EXPECT_TRUE(summary["depth"]["units_per_metre"].is_null());
}

TEST(Summary, NamesNoErrorsWhereThereWasNothingToCompare) {
  test::SampleRun run = sample_run(50);
  run.outcome.evaluation.reset();
  run.outcome.no_evaluation = "no ground truth";
  json summary = json::parse(to_json(summarize(sample_description(), run.log, run.outcome)));
  EXPECT_TRUE(summary["evaluation"].is_null());
  EXPECT_EQ(summary["no_evaluation"], "no ground truth");

  run = sample_run(5);
  run.outcome.evaluation->final_poses.rpe_pairs = 0;
  run.outcome.evaluation->final_poses.drift.reset();
  summary = json::parse(to_json(summarize(sample_description(), run.log, run.outcome)));
  EXPECT_TRUE(summary["evaluation"]["final"]["rpe_translation_rmse_m_per_s"].is_null());
  EXPECT_TRUE(summary["evaluation"]["final"]["drift_percent"].is_null());
}

TEST(Summary, OfNothingIsStillASummary) {
  const json summary = json::parse(to_json(summarize({}, {}, {})));
  EXPECT_EQ(summary["frames"]["tracked"], 0);
  EXPECT_EQ(summary["frames_per_second"], 0);
}

std::vector<FrameRecord> finished_at(const std::vector<double>& seconds) {
  std::vector<FrameRecord> frames;
  for (const double s : seconds) frames.push_back({.finished = s});
  return frames;
}

TEST(SlowestSecond, MayBeginAtTheStartOrAtTheEndOfAnyFrame) {
  EXPECT_EQ(slowest_second(finished_at({0.9, 1.2, 1.4, 1.6, 1.85, 1.95, 2.3})), 1);
  EXPECT_EQ(slowest_second(finished_at({0.1, 0.2, 0.3, 1.25, 1.3, 1.4, 1.5})), 1);
  EXPECT_EQ(slowest_second(finished_at({0.5, 3, 3.5, 4.1})), 0);
}

TEST(SlowestSecond, NeedsARunOfASecond) {
  EXPECT_EQ(slowest_second(finished_at({0.1, 0.5, 0.99})), std::nullopt);
  EXPECT_EQ(slowest_second({}), std::nullopt);
  EXPECT_TRUE(json::parse(to_json(summarize({}, {}, {})))["slowest_second_frames"].is_null());
}

TEST(Quantile, InterpolatesBetweenNeighbours) {
  EXPECT_DOUBLE_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile({1, 2}, 0.5), 1.5);
  EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.95), 9.5);
  EXPECT_DOUBLE_EQ(quantile({7}, 0.99), 7);
  EXPECT_DOUBLE_EQ(quantile({}, 0.5), 0);
}

TEST(ConfigHash, IsTheKnownFunction) {
  EXPECT_EQ(config_hash(""), "cbf29ce484222325");
  EXPECT_EQ(config_hash("a"), "af63dc4c8601ec8c");  // published test value of FNV-1a
}

TEST(PathLength, AddsTheStepsUp) {
  const Trajectory path = {{.world_from_camera = {.translation = {0, 0, 0}}},
                           {.world_from_camera = {.translation = {3, 4, 0}}},
                           {.world_from_camera = {.translation = {3, 4, 2}}}};
  EXPECT_DOUBLE_EQ(path_length(path), 7);
}

}  // namespace
}  // namespace edvo
