// SPDX-License-Identifier: MIT
#include "edvo/io/trajectory_file.hpp"
#include "support/error_matcher.hpp"
#include "support/matchers.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <limits>

namespace edvo {
namespace {

using test::fails_with;
using test::NearPose;
using test::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TrajectoryFile parse(std::string_view text) {
  return parse_trajectory(text, "a.txt");
}

std::string content_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(TrajectoryFile, ReadsStampPositionAndQuaternion) {
  const TrajectoryFile file = parse("1305031102.175304 1 -2 3.5 0 0 0.6 0.8\n");
  ASSERT_EQ(file.trajectory.size(), 1u);
  EXPECT_EQ(to_string(file.trajectory[0].stamp), "1305031102.175304");
  const SE3 expected{.rotation = Eigen::Quaterniond(0.8, 0, 0, 0.6), .translation = {1, -2, 3.5}};
  EXPECT_THAT(file.trajectory[0].world_from_camera, NearPose(expected, 1e-12));
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(TrajectoryFile, ReadsWhatOtherProgramsWrite) {
  // Comments, blank lines, CRLF, commas, tabs, exponents, plus signs, a byte order mark, no last
  // line break.
  const TrajectoryFile file = parse(
      "\xEF\xBB\xBF# stamp tx ty tz qx qy qz qw\r\n\r\n"
      "1.0, 1e-3,0,0, 0,0,0,1\r\n"
      "  # indented\n"
      "\t1.1\t+2\t0\t0\t0\t0\t0\t1\n"
      "1.200000000000000000e+00 3 0 0 0 0 0 1");
  ASSERT_EQ(file.trajectory.size(), 3u);
  EXPECT_DOUBLE_EQ(file.trajectory[0].world_from_camera.translation.x(), 1e-3);
  EXPECT_DOUBLE_EQ(file.trajectory[1].world_from_camera.translation.x(), 2);
  EXPECT_EQ(file.trajectory[2].stamp.nanoseconds, 1'200'000'000);
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(TrajectoryFile, ReadsTheCsvOfEuroc) {
  const TrajectoryFile file = parse(
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
      "q_RS_z [],v_RS_R_x [m s^-1]\n"
      "1403636580838555648,1,-2,3.5,0.8,0,0,0.6,0.1\r\n"
      "1403636580843555584,1,-2,3.6,0.8,0,0,0.6,0.1\r\n");
  ASSERT_EQ(file.trajectory.size(), 2u);
  EXPECT_EQ(to_string(file.trajectory[0].stamp), "1403636580.838555648");
  const SE3 expected{.rotation = Eigen::Quaterniond(0.8, 0, 0, 0.6), .translation = {1, -2, 3.5}};
  EXPECT_THAT(file.trajectory[0].world_from_camera, NearPose(expected, 1e-12));
  EXPECT_THAT(file.warnings, ElementsAre(HasSubstr("EuRoC")));
}

TEST(TrajectoryFile, TakesTheOrderOfAQuaternionFromTheComment) {
  const SE3 expected{.rotation = Eigen::Quaterniond(0.8, 0, 0, 0.6)};
  const TrajectoryFile w_first = parse("# t x y z qw qx qy qz\n1 0 0 0 0.8 0 0 0.6\n");
  EXPECT_THAT(w_first.trajectory.at(0).world_from_camera, NearPose(expected, 1e-12));
  EXPECT_THAT(w_first.warnings, ElementsAre(HasSubstr("qw first")));
  const TrajectoryFile w_last = parse("# t x y z qx qy qz qw\n1 0 0 0 0 0 0.6 0.8\n");
  EXPECT_THAT(w_last.trajectory.at(0).world_from_camera, NearPose(expected, 1e-12));
  EXPECT_THAT(w_last.warnings, IsEmpty());
}

TEST(TrajectoryFile, PassesOverAHeaderThatIsNoComment) {
  const SE3 expected{.rotation = Eigen::Quaterniond(0.8, 0, 0, 0.6)};
  const TrajectoryFile seconds = parse("timestamp,tx,ty,tz,qw,qx,qy,qz\n1.5,0,0,0,0.8,0,0,0.6\n");
  ASSERT_EQ(seconds.trajectory.size(), 1u);
  EXPECT_THAT(seconds.trajectory[0].world_from_camera, NearPose(expected, 1e-12));
  const TrajectoryFile nanoseconds =
      parse("timestamp,tx,ty,tz,qx,qy,qz,qw\n1403636580838555648,0,0,0,0,0,0.6,0.8\n");
  EXPECT_EQ(to_string(nanoseconds.trajectory.at(0).stamp), "1403636580.838555648");
  EXPECT_THAT(nanoseconds.trajectory[0].world_from_camera, NearPose(expected, 1e-12));
  EXPECT_THAT(nanoseconds.warnings, ElementsAre(HasSubstr("nanoseconds, qx first")));
}

TEST(TrajectoryFile, SaysOfNanosecondsHowTheyBecomeSeconds) {
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt:1:", "divide nanoseconds by 1e9"},
                         [] { (void)parse("1403636580838555648 0 0 0 0 0 0 1\n"); }));
}

TEST(TrajectoryFile, NamesTheUnitOfStampsThatAreTooLarge) {
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"divide milliseconds by 1000"},
                         [] { (void)parse("1403636580838 0 0 0 0 0 0 1\n"); }));
}

TEST(TrajectoryFile, SaysThatMcapIsNotRead) {
  const TemporaryFolder folder;
  const auto file = folder.write("path.mcap", "\x89MCAP0\r\n");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"path.mcap", "MCAP is not read"},
                         [&] { (void)read_trajectory(file); }));
}

TEST(TrajectoryFile, NamesTheMatricesOfKitti) {
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"got 12", "KITTI", "stamps of times.txt"},
                         [] { (void)parse("1 0 0 0 0 1 0 0 0 0 1 0\n"); }));
}

TEST(TrajectoryFile, NamesTheLineThatIsNoPose) {
  const auto parsing = [](std::string_view text) { return [text] { (void)parse(text); }; };
  const std::string good = "# header\n1 0 0 0 0 0 0 1\n";
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt:3:", "expected 8 fields", "got 4"},
                         parsing(good + "2 0 0 0\n")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt:3:", "got 12"},
                         parsing(good + "1 0 0 0 0 1 0 0 0 0 1 0\n")));
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"a.txt:3:", "\"nan\""}, parsing(good + "2 nan 0 0 0 0 0 1")));
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"a.txt:3:", "\"inf\""}, parsing(good + "2 0 0 0 0 0 0 inf")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt:3:", "\"1.5x\""},
                         parsing(good + "2 0 1.5x 0 0 0 0 1")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt:3:", "quaternion of length 0"},
                         parsing(good + "2 0 0 0 0 0 0 0")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt:3:", "stamp", "\"nan\""},
                         parsing(good + "nan 0 0 0 0 0 0 1")));
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"a.txt:3:", "1e999"}, parsing(good + "2 1e999 0 0 0 0 0 1")));
}

TEST(TrajectoryFile, DoesNotRepeatBinaryRubbishInMessages) {
  const std::string rubbish = "1 \x1B[31m" + std::string(1000, 'x') + " 0 0 0 0 0 1\n";
  const auto error = test::error_of([&] { (void)parse(rubbish); });
  ASSERT_TRUE(error);
  EXPECT_LT(std::string(error->what()).size(), 200u);
  EXPECT_EQ(std::string(error->what()).find('\x1B'), std::string::npos);
}

TEST(TrajectoryFile, RefusesAFileWithoutPoses) {
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"a.txt", "no pose"}, [] { (void)parse("# nothing\n\n"); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.txt", "no pose"}, [] { (void)parse(""); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"/no/such/file"},
                         [] { (void)read_trajectory("/no/such/file"); }));
}

TEST(TrajectoryFile, SortsAndSaysSo) {
  const TrajectoryFile file = parse(
      "3 3 0 0 0 0 0 1\n"
      "1 1 0 0 0 0 0 1\n"
      "2 2 0 0 0 0 0 1\n");
  ASSERT_EQ(file.trajectory.size(), 3u);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(file.trajectory[i].world_from_camera.translation.x(), i + 1);
  EXPECT_THAT(file.warnings, ElementsAre(HasSubstr("a.txt:2: stamp before the previous one")));
}

TEST(TrajectoryFile, KeepsTheLastPoseOfAStampAsTheScriptsDo) {
  const TrajectoryFile file = parse(
      "1 1 0 0 0 0 0 1\n"
      "2 2 0 0 0 0 0 1\n"
      "2.0 5 0 0 0 0 0 1\n");
  ASSERT_EQ(file.trajectory.size(), 2u);
  EXPECT_EQ(file.trajectory[1].world_from_camera.translation.x(), 5);
  EXPECT_THAT(file.warnings, ElementsAre(HasSubstr("a.txt:3: stamp seen before")));
}

TEST(TrajectoryFile, NormalizesQuaternionsAndSaysSoOnce) {
  const TrajectoryFile file = parse("1 0 0 0 0 0 0 2\n2 0 0 0 0 0 0 0.5\n3 0 0 0 0 0 0 1.000001\n");
  for (const StampedPose& pose : file.trajectory)
    EXPECT_DOUBLE_EQ(pose.world_from_camera.rotation.norm(), 1.0);
  EXPECT_THAT(file.warnings,
              ElementsAre(testing::AllOf(HasSubstr("a.txt:1:"), HasSubstr("2 such lines"))));
}

TEST(TrajectoryFile, WritesStampsAsTheyCame) {
  for (const char* stamp : {"1305031102.175304", "1305031449.7996", "12", "1403636579.763555584"}) {
    const TrajectoryFile file = parse(std::string(stamp) + " 0 0 0 0 0 0 1");
    EXPECT_THAT(trajectory_line(file.trajectory[0]), testing::StartsWith(std::string(stamp) + " "));
  }
}

TEST(TrajectoryFile, ReadsWhatItWrote) {
  const TemporaryFolder folder;
  Trajectory trajectory;
  for (int i = 0; i < 50; ++i) {
    Vector6d xi;
    xi << 0.1 * i, -2, 1e-4 * i, 0.05 * i, 0.3, -0.02 * i;
    trajectory.push_back({.stamp = {.nanoseconds = 1'305'031'102'175'304'000 + i * 33'000'000LL},
                          .world_from_camera = exp(xi)});
  }
  write_trajectory(folder.path() / "t.tum", trajectory);
  const TrajectoryFile read = read_trajectory(folder.path() / "t.tum");
  EXPECT_THAT(read.warnings, IsEmpty());
  ASSERT_EQ(read.trajectory.size(), trajectory.size());
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    EXPECT_EQ(read.trajectory[i].stamp, trajectory[i].stamp);
    EXPECT_THAT(read.trajectory[i].world_from_camera,
                NearPose(trajectory[i].world_from_camera, 5e-9));
  }
}

TEST(TrajectoryFile, NeverWritesANaN) {
  StampedPose pose;
  pose.world_from_camera.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(
      fails_with(ErrorCode::kInternal, {"not finite"}, [&] { (void)trajectory_line(pose); }));
}

TEST(TrajectoryFile, LeavesTheOldFileWhereTheNewOneCannotBeWritten) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.write("t.tum", "1 0 0 0 0 0 0 1\n");
  const Trajectory trajectory(1000);
  // A limit on the file size stands in for a full disk.
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  rlimit unlimited{};
  getrlimit(RLIMIT_FSIZE, &unlimited);
  rlimit tiny = unlimited;
  tiny.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &tiny);
  const auto error = test::error_of([&] { write_trajectory(file, trajectory); });
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, previous);

  ASSERT_TRUE(error);
  EXPECT_EQ(error->code(), ErrorCode::kOutput);
  EXPECT_EQ(content_of(file), "1 0 0 0 0 0 0 1\n");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(TrajectoryFile, SaysWhereItCannotWrite) {
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"/no/such/folder/t.tum"},
                         [] { write_trajectory("/no/such/folder/t.tum", Trajectory(1)); }));
}

TEST(TrajectoryFile, MarksSegmentsByCommentsThatReadersPassOver) {
  const test::TemporaryFolder folder;
  Trajectory trajectory;
  for (int i = 0; i < 4; ++i)
    trajectory.push_back({.stamp = stamp_from_seconds(i, 1), .segment = i < 2 ? 0 : 1});
  write_trajectory(folder.path() / "poses.tum", trajectory);
  std::ifstream stream(folder.path() / "poses.tum");
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[2], "# segment 1");
  const Trajectory read = read_trajectory(folder.path() / "poses.tum").trajectory;
  ASSERT_EQ(read.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(read[i].segment, trajectory[i].segment);
}

TEST(TrajectoryFile, TakesNoOtherCommentForASegment) {
  for (const char* comment : {"# segment", "# segment x", "# segment -1", "# segment 1 of 2",
                              "# a segment 1", "#segment", "# segment 99999999999"}) {
    const TrajectoryFile file = parse(std::string(comment) + "\n1 0 0 0 0 0 0 1\n");
    EXPECT_EQ(file.trajectory.at(0).segment, 0) << comment;
  }
}

TEST(TrajectoryFile, BelievesAHeaderThatSaysNanosecondsOfStampsNearZero) {
  const TrajectoryFile file = parse(
      "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
      "q_RS_z []\n0,1,0,0,1,0,0,0\n33333333,2,0,0,1,0,0,0\n");
  ASSERT_EQ(file.trajectory.size(), 2u);
  EXPECT_EQ(to_string(file.trajectory[1].stamp), "0.033333333");
  EXPECT_THAT(file.warnings, ElementsAre(HasSubstr("EuRoC")));
}

TEST(TrajectoryFile, StampsWhoseDifferencesDoNotFitAreRefused) {
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"far.tum:2", "stamp", "9e9"}, [] {
    (void)parse_trajectory("1 0 0 0 0 0 0 1\n9e9 0 0 0 0 0 0 1\n", "far.tum");
  }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"far.tum:1"},
                         [] { (void)parse_trajectory("-9e9 0 0 0 0 0 0 1\n", "far.tum"); }));
  EXPECT_EQ(parse_trajectory("-3.9e9 0 0 0 0 0 0 1\n3.9e9 0 0 0 0 0 0 1\n", "").trajectory.size(),
            2U);
}

}  // namespace
}  // namespace edvo
