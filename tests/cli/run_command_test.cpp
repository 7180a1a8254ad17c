// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "support/program.hpp"
#include "support/shared_data.hpp"
#include "support/sliding_sequence.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_edvo;
using test::sliding_stamp;
using test::write_sliding_sequence;
using ::testing::HasSubstr;
using ::testing::Not;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class RunCommand : public testing::Test {
 protected:
  // edvo run SEQUENCE -o OUT arguments
  test::ProgramResult run(const std::string& arguments) const {
    return run_edvo("run " + sequence().string() + " -o " + out().string() + " " + arguments);
  }
  [[nodiscard]] fs::path sequence() const { return folder_.path() / "sliding"; }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }

  test::TemporaryFolder folder_;
};

TEST_F(RunCommand, TracksEvaluatesAndWritesTheWholeFolder) {
  write_sliding_sequence(sequence());
  const auto result = run("2>/dev/null");
  ASSERT_EQ(result.status, 0);
  for (const char* part : {"12 tracked, 0 lost", "ATE", "TUM protocol", "coverage 100.0 %"})
    EXPECT_THAT(result.output, HasSubstr(part));
  for (const char* name : {"frames.jsonl", "trajectory.tum", "trajectory_online.tum",
                           "keyframes.tum", "summary.json", "config.toml", "report.html"})
    EXPECT_TRUE(fs::is_regular_file(out() / name)) << name;
  const Trajectory trajectory = read_trajectory(out() / "trajectory.tum").trajectory;
  ASSERT_EQ(trajectory.size(), 12u);
  EXPECT_EQ(to_string(trajectory[3].stamp), sliding_stamp(3));
  const json summary = json::parse(text_of(out() / "summary.json"));
  EXPECT_LT(summary["evaluation"]["final"]["ate_rmse_m"], 0.01);
  EXPECT_GT(summary["finish_s"], 0);
  EXPECT_THAT(result.output, HasSubstr(" s for the last pass"));
}

TEST_F(RunCommand, LeavesTheFinalPassOutIfTold) {
  write_sliding_sequence(sequence());
  ASSERT_EQ(run("--no-final-pass --set window.final_iterations=9 2>/dev/null").status, 0);
  EXPECT_THAT(text_of(out() / "config.toml"), HasSubstr("final_iterations = 0"));
}

TEST_F(RunCommand, PrintsOneJsonObjectAndSendsTheRestToStderr) {
  write_sliding_sequence(sequence());
  const auto result = run("--json 2>/dev/null");
  ASSERT_EQ(result.status, 0);
  const json summary = json::parse(result.output);
  EXPECT_EQ(summary["frames"]["tracked"], 12);
  EXPECT_EQ(summary["folder"], out().string());
  EXPECT_THAT(summary["command"].get<std::string>(), HasSubstr("--json"));
}

TEST_F(RunCommand, GivesTheSameBitsWithAnyNumberOfThreads) {
  write_sliding_sequence(sequence());
  ASSERT_EQ(run("--threads 1 2>&1").status, 0);
  const std::string one = text_of(out() / "trajectory.tum");
  ASSERT_EQ(run("--threads 2 --force 2>&1").status, 0);
  EXPECT_EQ(text_of(out() / "trajectory.tum"), one);
  ASSERT_EQ(run("--threads 4 --force 2>&1").status, 0);
  EXPECT_EQ(text_of(out() / "trajectory.tum"), one);
}

TEST_F(RunCommand, SaysWhichCameraItTookAndWhy) {
  write_sliding_sequence(sequence());
  const auto result = run("2>&1 >/dev/null");
  EXPECT_THAT(result.output, HasSubstr("camera    "));
  EXPECT_THAT(result.output, HasSubstr("calibration.txt"));
  EXPECT_THAT(result.output, HasSubstr("100 %  frame 12/12"));
}

TEST_F(RunCommand, IsQuietWhenAskedTo) {
  write_sliding_sequence(sequence(), {.frames = 24});  // shorter ones are warned of: no RPE
  EXPECT_EQ(run("--quiet 2>&1 >/dev/null").output, "");
}

TEST_F(RunCommand, TakesAPartOfTheSequence) {
  write_sliding_sequence(sequence());
  ASSERT_EQ(run("--start 3 --max-frames 5 --no-report 2>&1").status, 0);
  const Trajectory trajectory = read_trajectory(out() / "trajectory.tum").trajectory;
  ASSERT_EQ(trajectory.size(), 5u);
  EXPECT_EQ(to_string(trajectory[0].stamp), sliding_stamp(3));
  EXPECT_EQ(json::parse(text_of(out() / "frames.jsonl")
                            .substr(0, text_of(out() / "frames.jsonl").find('\n')))["index"],
            3);
  EXPECT_FALSE(fs::exists(out() / "report.html"));
  const auto beyond = run("--start 12 --force 2>&1");
  EXPECT_EQ(beyond.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(beyond.output, HasSubstr("only 12 frames"));
}

TEST_F(RunCommand, SkipsReportsAndCountsADamagedFrame) {
  write_sliding_sequence(sequence());
  const fs::path damaged = sequence() / "rgb" / (sliding_stamp(5) + ".png");
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  const auto result = run("--json 2>" + (folder_.path() / "log").string());
  ASSERT_EQ(result.status, 0);
  const json summary = json::parse(result.output);
  EXPECT_EQ(summary["frames"]["tracked"], 11);
  EXPECT_EQ(summary["frames"]["skipped"], 1);
  EXPECT_EQ(summary["skipped"][0]["index"], 5);
  EXPECT_EQ(summary["skipped"][0]["stamp"], sliding_stamp(5));
  EXPECT_THAT(summary["skipped"][0]["reason"].get<std::string>(), HasSubstr(damaged.string()));
  EXPECT_THAT(text_of(folder_.path() / "log"), HasSubstr("frame 5 skipped"));
  EXPECT_THAT(text_of(out() / "frames.jsonl"), HasSubstr("\"skipped\""));
}

TEST_F(RunCommand, SucceedsWithAWarningWhereGroundTruthDoesNotOverlap) {
  write_sliding_sequence(sequence(), {.ground_truth_offset = 1000});
  const auto result = run("2>&1");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, HasSubstr("warning: no evaluation"));
  EXPECT_EQ(read_trajectory(out() / "trajectory.tum").trajectory.size(), 12u);
}

TEST_F(RunCommand, SucceedsWithAWarningWhereGroundTruthIsNoTrajectory) {
  write_sliding_sequence(sequence());
  std::ofstream(sequence() / "groundtruth.txt") << "1 2 three\n";
  const auto result = run("2>&1");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, HasSubstr("groundtruth.txt:1"));
}

TEST_F(RunCommand, WritesThePointsOfItsKeyframes) {
  write_sliding_sequence(sequence());
  const fs::path points = folder_.path() / "points.ply";
  ASSERT_EQ(run("--points " + points.string() + " 2>&1").status, 0);
  const std::string text = text_of(points);
  const std::string vertices = "element vertex ";
  const std::size_t begin = text.find(vertices);
  ASSERT_NE(begin, std::string::npos);
  const auto count = std::stoul(text.substr(begin + vertices.size()));
  EXPECT_GT(count, 100U);
  const std::string end = "end_header\n";
  EXPECT_EQ(text.size(), text.find(end) + end.size() + 15 * count);

  const auto again =
      run_edvo("run " + sequence().string() + " --points " + points.string() + " 2>&1");
  EXPECT_EQ(again.status, static_cast<int>(ErrorCode::kOutput));
  EXPECT_THAT(again.output, HasSubstr("replace it with --force"));
  EXPECT_EQ(text_of(points), text);
}

TEST_F(RunCommand, SaysWhatThePythonPackageReads) {
  const auto says = [](const std::string& command, const std::string& words) {
    const auto result = run_edvo(command + " 2>&1");
    EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kUsage)) << command;
    EXPECT_THAT(result.output, HasSubstr(words));
  };
  folder_.write("a.bag", "#ROSBAG V2.0");
  folder_.write("ros2/metadata.yaml", "rosbag2_bagfile_information:");
  folder_.write("stray/rgb.mp4", "");
  folder_.write("stray/camera_matrix.csv", "");
  const auto place = [&](const char* name) { return (folder_.path() / name).string(); };
  says("run " + place("a.bag"),
       "a.bag: reading it needs the Python package: in a checkout of edvo, pip install '.[ros]'");
  says("run " + place("ros2"), "pip install '.[ros]'");
  says("run " + place("stray"), "pip install '.[video]'");
  says("run camera:oak", "needs the Python package");
  says("pull tum/fr1/xyz",
       "edvo pull needs the Python package: in a checkout of edvo, pip install .");
  says("view runs/x",
       "edvo view needs the Python package: in a checkout of edvo, pip install '.[view]'");
  says("run x --view",
       "--view needs the Python package: in a checkout of edvo, pip install '.[view]'");
  EXPECT_THAT(run_edvo("run " + place("none.bag") + " 2>&1").output, HasSubstr("no such"));
}

TEST_F(RunCommand, FailsWhereNothingCanBeTracked) {
  write_sliding_sequence(sequence());
  for (int i = 0; i < 12; ++i)
    write_png(sequence() / "depth" / (sliding_stamp(i) + ".png"),
              cv::Mat(120, 160, CV_16UC1, cv::Scalar::all(0)));
  const auto result = run("2>&1");
  EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kTrackingLost)) << result.output;
  EXPECT_THAT(result.output, HasSubstr("none of 12 frames"));
  EXPECT_THAT(result.output, HasSubstr("12 of them because hardly a pixel has a depth in range"));
  EXPECT_TRUE(fs::exists(out() / "frames.jsonl"));
}

TEST_F(RunCommand, DoesNotReplaceAnEarlierRunUnasked) {
  write_sliding_sequence(sequence());
  ASSERT_EQ(run("2>&1").status, 0);
  const auto again = run("2>&1");
  EXPECT_EQ(again.status, static_cast<int>(ErrorCode::kOutput));
  EXPECT_THAT(again.output, HasSubstr("--force"));
  EXPECT_EQ(run("--force 2>&1").status, 0);
}

TEST_F(RunCommand, StopsAfterTheCurrentFrameAndFinishesWhenInterrupted) {
  write_sliding_sequence(sequence(), {.frames = 300});
  const std::string log = (folder_.path() / "log").string();
  for (const char* signal : {"INT", "TERM"}) {
    // The program is told to stop as soon as its first frame is on disk.
    const std::string script = "(run=$PPID; while ! [ -s " + (out() / "frames.jsonl").string() +
                               " ]; do sleep 0.01; done;"
                               " exec kill -" +
                               signal + " $(cat " + (folder_.path() / "pid").string() + "))";
    const auto result =
        run_edvo("--help >/dev/null; rm -rf " + out().string() + "; " + EDVO_PROGRAM + " run " +
                 sequence().string() + " -o " + out().string() + " --threads 1 >" + log +
                 " 2>&1 & echo $! >" + (folder_.path() / "pid").string() + "; " + script +
                 "; wait $(cat " + (folder_.path() / "pid").string() + ")");
    EXPECT_EQ(result.status, 130) << text_of(log);
    const json summary = json::parse(text_of(out() / "summary.json"));
    EXPECT_EQ(summary["interrupted"], true);
    EXPECT_LT(summary["frames"]["tracked"], 300);
    EXPECT_EQ(read_trajectory(out() / "trajectory.tum").trajectory.size(),
              summary["frames"]["tracked"]);
    EXPECT_TRUE(fs::exists(out() / "report.html"));
  }
}

TEST_F(RunCommand, RefusesBadInputWithItsOwnStatus) {
  const auto status_of = [&](const std::string& arguments) {
    return run_edvo("run " + arguments + " 2>/dev/null").status;
  };
  const auto code = [](ErrorCode error) { return static_cast<int>(error); };
  EXPECT_EQ(status_of("/no/such/folder"), code(ErrorCode::kInput));
  EXPECT_EQ(status_of(folder_.path().string()), code(ErrorCode::kInput));
  write_sliding_sequence(sequence());
  EXPECT_EQ(status_of(sequence().string() + " --set window.keyframes=-1"),
            code(ErrorCode::kConfig));
  EXPECT_EQ(status_of(sequence().string() + " --camera /no/such.yaml"),
            code(ErrorCode::kCalibration));
  EXPECT_EQ(status_of(sequence().string() + " --threads 0"), code(ErrorCode::kUsage));
  EXPECT_EQ(status_of(sequence().string() + " --depth-scale -1"), code(ErrorCode::kUsage));
  EXPECT_EQ(status_of(sequence().string() + " -o /proc/nowhere"), code(ErrorCode::kOutput));
  const auto misspelled = run_edvo("run " + sequence().string() + " --thread 2 2>&1");
  EXPECT_EQ(misspelled.status, code(ErrorCode::kUsage));
  EXPECT_THAT(misspelled.output, HasSubstr("did you mean '--threads'?"));
}

TEST_F(RunCommand, WarnsOfAnImplausibleDepthScale) {
  write_sliding_sequence(sequence());
  const auto result = run("--depth-scale 50 2>&1 >/dev/null");
  EXPECT_THAT(result.output, HasSubstr("warning: "));
  EXPECT_THAT(result.output, HasSubstr("5000"));
}

TEST_F(RunCommand, SaysThatTheDepthScaleIsAssumedAndWhatTheGroundTruthMakesOfIt) {
  write_sliding_sequence(sequence());
  const auto assumed = run("2>&1");
  EXPECT_THAT(assumed.output, HasSubstr("5000 units per metre, which is assumed"));
  const json summary = json::parse(text_of(out() / "summary.json"));
  EXPECT_EQ(summary["depth"]["assumed"], true);
  EXPECT_NEAR(summary["evaluation"]["sim3_scale"].get<double>(), 1, 0.02);
  const auto wrong = run("--force --depth-scale 4000 2>&1");
  EXPECT_THAT(wrong.output, HasSubstr("--depth-scale 5000"));
  EXPECT_THAT(wrong.output, Not(HasSubstr("which is assumed")));
}

TEST_F(RunCommand, ScalesACameraOfAnotherSize) {
  write_sliding_sequence(sequence());
  const auto missized = run("--camera-size 640 2>&1");
  EXPECT_EQ(missized.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(missized.output, HasSubstr("--camera-size 640: expected WIDTHxHEIGHT"));
  const auto scaled = run("--camera-size 320x240 2>&1");
  EXPECT_THAT(scaled.output, HasSubstr("scaled from 320 x 240 px to 160 x 120 px"));
}

TEST_F(RunCommand, PutsResultsUnderRunsByDefault) {
  write_sliding_sequence(sequence());
  const auto result = run_edvo("--help >/dev/null; cd " + folder_.path().string() + " && " +
                               EDVO_PROGRAM + " run sliding 2>&1");
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_TRUE(fs::exists(folder_.path() / "runs/sliding/latest/report.html"));
}

}  // namespace
}  // namespace edvo
