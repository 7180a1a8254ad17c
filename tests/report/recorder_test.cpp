// SPDX-License-Identifier: MIT
#include "edvo/report/recorder.hpp"

#include "edvo/io/trajectory_file.hpp"
#include "report/sample_run.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::sample_description;
using test::sample_report;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<json> lines_of(const fs::path& file) {
  std::vector<json> lines;
  std::istringstream text(text_of(file));
  for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
  return lines;
}

constexpr bool kWithHtml = true;

// Of frames 0 to count - 1: the poses known at the time are the final ones.
RunOutcome outcome_of(int count) {
  RunOutcome outcome;
  for (int i = 0; i < count; ++i) {
    const FrameResult result = sample_report(i);
    add_to(outcome.counts, result);
    outcome.online.push_back({result.stamp, result.world_from_camera});
  }
  outcome.trajectory = outcome.online;
  outcome.keyframes = {outcome.online.front()};
  return outcome;
}

TEST(Recorder, HasEveryFrameOnDiskAsSoonAsItIsTold) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  for (int i = 0; i < 5; ++i) {
    recorder.frame(sample_report(i), {});
    const std::vector<json> lines = lines_of(folder.path() / "frames.jsonl");
    ASSERT_EQ(lines.size(), i + 1u);
    EXPECT_EQ(lines.back()["index"], i);
    EXPECT_EQ(lines.back()["stamp"], to_string(sample_report(i).stamp));
    EXPECT_EQ(read_trajectory(folder.path() / "trajectory.tum").trajectory.size(), i + 1u);
  }
}

TEST(Recorder, WritesWhatIsKnownOfAFrame) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  FrameResult report = sample_report(20);
  report.world_from_camera = {.translation = {1, 2, 3}};
  report.information(0, 5) = 7;
  report.segment = 1;
  report.keyframe = 3;
  report.new_keyframe = 4;
  report.keyframe_from_camera = {.translation = {0, 0, 0.5}};
  recorder.frame(report, {});
  const json line = lines_of(folder.path() / "frames.jsonl").front();
  EXPECT_EQ(line["status"], "tracked");
  EXPECT_EQ(line["segment"], 1);
  EXPECT_EQ(line["keyframe"], 3);
  EXPECT_EQ(line["new_keyframe"], 4);
  EXPECT_EQ(line["keyframe_reason"], "period");
  EXPECT_THAT(line["keyframe_from_camera"], ElementsAre(0, 0, 0.5, 0, 0, 0, 1));
  EXPECT_TRUE(line["loss_cause"].is_null());
  EXPECT_THAT(line["pose"], ElementsAre(1, 2, 3, 0, 0, 0, 1));
  EXPECT_EQ(line["levels"].size(), 2u);
  EXPECT_EQ(line["levels"][1]["converged"], false);
  EXPECT_EQ(line["information"].size(), 21u);
  EXPECT_EQ(line["information"][5], 7);
  EXPECT_EQ(line["ms"].size(), kStages.size() + 1);
}

TEST(Recorder, LeavesLostFramesOutOfTheTrajectory) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  FrameResult lost = sample_report(1);
  lost.status = FrameStatus::kLost;
  for (const FrameResult& report : {sample_report(0), lost, sample_report(2)})
    recorder.frame(report, {});
  EXPECT_EQ(read_trajectory(folder.path() / "trajectory.tum").trajectory.size(), 2u);
  EXPECT_EQ(lines_of(folder.path() / "frames.jsonl")[1]["status"], "lost");
}

TEST(Recorder, NamesTheCauseOfALoss) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  FrameResult lost{.status = FrameStatus::kLost, .loss_cause = LossCause::kNoDepth};
  recorder.frame(lost, {});
  const json line = lines_of(folder.path() / "frames.jsonl").front();
  EXPECT_EQ(line["loss_cause"], "no_depth");
  EXPECT_TRUE(line["keyframe"].is_null());
}

TEST(Recorder, MarksWhereANewSegmentBegins) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  FrameResult restarted = sample_report(2);
  restarted.status = FrameStatus::kRestarted;
  restarted.segment = 1;
  for (const FrameResult& result : {sample_report(0), sample_report(1), restarted})
    recorder.frame(result, {});
  std::istringstream text(text_of(folder.path() / "trajectory.tum"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[2], "# segment 1");
}

TEST(Recorder, WritesNullForWhatIsNotANumber) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  FrameResult report = sample_report(1);
  report.status = FrameStatus::kLost;
  report.rms = std::numeric_limits<double>::quiet_NaN();
  report.levels[0].cost = std::numeric_limits<double>::infinity();
  report.information(0, 0) = std::numeric_limits<double>::quiet_NaN();
  recorder.frame(report, {});
  const json line = lines_of(folder.path() / "frames.jsonl").front();
  EXPECT_TRUE(line["rms"].is_null());
  EXPECT_TRUE(line["levels"][0]["cost"].is_null());
  EXPECT_TRUE(line["information"][0].is_null());
}

TEST(Recorder, NamesSkippedFramesAndTheirReason) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  recorder.skipped(SkippedFrame{.index = 3, .stamp = "1.5", .reason = "3.png: truncated \xff"});
  const json line = lines_of(folder.path() / "frames.jsonl").front();
  EXPECT_EQ(line["status"], "skipped");
  EXPECT_THAT(line["reason"].get<std::string>(), HasSubstr("3.png: truncated"));
}

TEST(Recorder, FinishReplacesTheTrajectoryAndKeepsTheOneKnownAtTheTime) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  for (int i = 0; i < 4; ++i) recorder.frame(sample_report(i), {});
  const std::string live = text_of(folder.path() / "trajectory.tum");
  RunOutcome outcome = outcome_of(4);
  for (StampedPose& pose : outcome.trajectory) pose.world_from_camera.translation.x() += 1;
  recorder.end(outcome);
  EXPECT_EQ(recorder.summary().counts.tracked, 4);
  EXPECT_EQ(text_of(folder.path() / "trajectory_online.tum"), live);
  const Trajectory refined = read_trajectory(folder.path() / "trajectory.tum").trajectory;
  ASSERT_EQ(refined.size(), 4u);
  EXPECT_NEAR(refined[2].world_from_camera.translation.x(),
              outcome.trajectory[2].world_from_camera.translation.x(), 1e-9);
  EXPECT_EQ(read_trajectory(folder.path() / "keyframes.tum").trajectory.size(), 1u);
  EXPECT_EQ(json::parse(text_of(folder.path() / "summary.json"))["schema_version"], kSchemaVersion);
  EXPECT_EQ(text_of(folder.path() / "config.toml"), sample_description().config);
  EXPECT_THAT(text_of(folder.path() / "report.html"), HasSubstr("</html>"));
}

TEST(Recorder, ShowsPicturesOfTheWorstFramesInTheReport) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  const Frame image{.bgr = cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 20, 30))};
  for (int i = 0; i < 40; ++i) {
    FrameResult result = sample_report(i);
    if (i == 21) result.rms = 40;
    recorder.frame(result, image);
  }
  recorder.end(outcome_of(40));
  ASSERT_FALSE(recorder.log().worst.empty());
  EXPECT_EQ(recorder.log().worst.front().frame, 21);
  EXPECT_THAT(text_of(folder.path() / "report.html"),
              HasSubstr("data-frame=\"21\" src=\"data:image/jpeg;base64,/9j/"));
}

TEST(Recorder, LeavesNoHalfFilesBehind) {
  const test::TemporaryFolder folder;
  Recorder recorder(folder.path(), sample_description(), !kWithHtml);
  recorder.frame(sample_report(0), {});
  recorder.end(outcome_of(1));
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.path()))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  EXPECT_FALSE(fs::exists(folder.path() / "report.html"));
}

TEST(Recorder, SaysWhichFileCannotBeWritten) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "frames.jsonl");
  EXPECT_TRUE(test::fails_with(ErrorCode::kOutput, {"frames.jsonl"},
                               [&] { Recorder(folder.path(), sample_description(), kWithHtml); }));
  EXPECT_TRUE(test::fails_with(ErrorCode::kOutput, {"nowhere/frames.jsonl"}, [&] {
    Recorder(folder.path() / "nowhere", sample_description(), kWithHtml);
  }));
}

TEST(Recorder, SaysWhenTheDiskIsFull) {
  const test::TemporaryFolder folder;
  fs::create_symlink("/dev/full", folder.path() / "frames.jsonl");
  Recorder recorder(folder.path(), sample_description(), kWithHtml);
  EXPECT_TRUE(test::fails_with(ErrorCode::kOutput, {"frames.jsonl", "space"},
                               [&] { recorder.frame(sample_report(0), {}); }));
}

}  // namespace
}  // namespace edvo
