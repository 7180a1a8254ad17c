// SPDX-License-Identifier: MIT
#include "edvo/report/stored_run.hpp"

#include "edvo/io/file.hpp"
#include "edvo/report/html.hpp"
#include "edvo/report/recorder.hpp"
#include "report/sample_run.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <fstream>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;
using test::sample_description;
using test::sample_report;
using test::sample_run;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class StoredRunTest : public testing::Test {
 protected:
  // A run of so many frames as edvo run leaves it.
  void record(std::int64_t frames) {
    fs::create_directory(run_);
    Recorder recorder(run_, sample_description(), true);
    const Frame image{.bgr = cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 20, 30))};
    for (std::int64_t i = 0; i < frames; ++i) {
      FrameResult result = sample_report(i);
      if (i == 20) result.new_keyframe = 1;
      if (i == 60) result.new_keyframe = 3;
      if (i == 33) result.rms = 40;
      recorder.frame(result, image);
    }
    recorder.skipped({.index = frames, .stamp = "9", .reason = "9.png: truncated"});
    const LinkReport accepted{.from = 3, .to = 1, .status = LinkStatus::kAccepted};
    const LinkReport refused{.from = 3, .to = 0, .status = LinkStatus::kCycle};
    recorder.links(std::vector<LinkReport>{accepted, refused});
    recorder.end(sample_run(frames).outcome);
    written_ = recorder.log();
  }

  void remove(const char* name) const { fs::remove(run_ / name); }

  test::TemporaryFolder folder_;
  fs::path run_ = folder_.path() / "run";
  RunLog written_;
};

TEST_F(StoredRunTest, SaysAllThatTheSummarySaid) {
  record(420);  // some frames are lost
  EXPECT_EQ(to_json(read_run(run_).summary), read_file(run_ / "summary.json"));
}

TEST_F(StoredRunTest, HasTheFramesLinksAndPosesThatWereWritten) {
  record(420);
  const StoredRun run = read_run(run_);
  ASSERT_EQ(run.log.frames.size(), written_.frames.size());
  for (std::size_t i = 0; i < written_.frames.size(); ++i) {
    const FrameRecord &read = run.log.frames[i], &written = written_.frames[i];
    ASSERT_EQ(read.index, written.index);
    ASSERT_EQ(read.stamp, written.stamp);
    ASSERT_EQ(read.status, written.status);
    ASSERT_EQ(read.keyframe, written.keyframe);
    ASSERT_EQ(read.new_keyframe, written.new_keyframe);
    ASSERT_NEAR(read.inlier_ratio, written.inlier_ratio, 1e-4);
    ASSERT_NEAR(read.rms, written.rms, 1e-4);
    ASSERT_NEAR(read.milliseconds.tracking, written.milliseconds.tracking, 1e-3);
  }
  ASSERT_EQ(run.log.skipped.size(), 1u);
  EXPECT_EQ(run.log.skipped[0].reason, "9.png: truncated");
  ASSERT_EQ(run.log.links.size(), 1u);
  EXPECT_EQ(run.log.links[0].from, 3);
  EXPECT_EQ(run.log.links[0].to, 1);
  EXPECT_EQ(run.outcome.trajectory.size(), sample_run(420).outcome.trajectory.size());
  EXPECT_EQ(run.outcome.keyframes.size(), sample_run(420).outcome.keyframes.size());
}

TEST_F(StoredRunTest, FindsTheCurvesOfTheErrorsAndThePicturesAgain) {
  record(300);
  const StoredRun run = read_run(run_);
  EXPECT_THAT(run.missing, IsEmpty());
  ASSERT_TRUE(run.summary.evaluation);
  const TrajectoryErrors& errors = run.summary.evaluation->final_poses;
  EXPECT_EQ(errors.ate, 0.0123);
  EXPECT_EQ(errors.ate_curve.values.size(), 300u);
  EXPECT_FALSE(errors.rpe_translation_curve.values.empty());
  ASSERT_EQ(run.log.worst.size(), written_.worst.size());
  for (const WorstFrame& worst : run.log.worst) EXPECT_THAT(worst.picture, HasSubstr("/9j/"));
}

TEST_F(StoredRunTest, MakesTheSameReportAgain) {
  record(300);
  const StoredRun run = read_run(run_);
  const std::string page = to_html(run.summary, run.log, run.outcome);
  for (const char* part : {"Worst frames", "Events", "From above", "Absolute error over time",
                           "sees the place of frame 20", "levels = 4", "data:image/jpeg"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST_F(StoredRunTest, SaysWhatAnOlderRunDoesNotTell) {
  record(300);
  remove("groundtruth.tum");
  remove("report.html");
  const StoredRun run = read_run(run_);
  EXPECT_THAT(run.missing, ElementsAre(HasSubstr("groundtruth.tum"), HasSubstr("report.html")));
  EXPECT_EQ(run.summary.evaluation->final_poses.ate, 0.0123);
  EXPECT_THAT(to_html(run.summary, run.log, run.outcome), HasSubstr("</html>"));
}

TEST_F(StoredRunTest, RefusesWhatIsNoFinishedRunAndSaysWhatMendsIt) {
  const auto read = [&] { (void)read_run(run_); };
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"run", "no such folder", "edvo run"}, read));
  fs::create_directory(run_);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"not the folder of a run", "summary.json"}, read));
  fs::remove(run_);
  record(50);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"is a file", run_.string()},
                         [&] { (void)read_run(run_ / "summary.json"); }));
  fs::rename(run_, folder_.path() / "latest");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"holds runs", "latest"},
                         [&] { (void)read_run(folder_.path()); }));
  fs::rename(folder_.path() / "latest", run_);
  remove("summary.json");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"not ended", "run the sequence again"}, read));
}

TEST_F(StoredRunTest, NamesTheFileThatIsMissingOrDamaged) {
  record(50);
  const auto read = [&] { (void)read_run(run_); };
  remove("trajectory_online.tum");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"trajectory_online.tum", "missing", "again"}, read));
  std::ofstream(run_ / "frames.jsonl", std::ios::app) << "{\"index\": 50,\n";
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"frames.jsonl:52", "again"}, read));
  std::ofstream(run_ / "summary.json") << R"({"schema_version": 99, "edvo_version": "9.9"})";
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"summary.json", "schema_version 99", "9.9"}, read));
  std::ofstream(run_ / "summary.json") << R"({"schema_version": 2})";
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"summary.json", "not what edvo writes"}, read));
}

}  // namespace
}  // namespace edvo
