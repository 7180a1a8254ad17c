// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/dataset.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/synth/sequence.hpp"
#include "support/matchers.hpp"
#include "support/program.hpp"
#include "support/same_bits.hpp"
#include "support/temporary_folder.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace edvo {
namespace {

using test::NearPose;
using test::run_edvo;
using test::TemporaryFolder;
using ::testing::HasSubstr;

// A short sequence of small images; more arguments override these.
test::ProgramResult synth(const std::filesystem::path& out, const std::string& arguments = "") {
  return run_edvo(fmt::format("synth {} --scene boxes --size 160x120 --frames 5 {} 2>&1",
                              out.string(), arguments));
}

TEST(SynthCommand, WritesASequenceThatTheReaderGivesBack) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "room";
  ASSERT_EQ(synth(out).status, 0);
  const Dataset dataset = open_dataset(out);
  const ChosenCamera chosen = choose_camera(dataset);
  EXPECT_EQ(chosen.camera.pinhole.width, 160);
  EXPECT_DOUBLE_EQ(chosen.camera.pinhole.fx, 525.0 / 4);
  ASSERT_EQ(dataset.frames.size(), 5U);
  EXPECT_EQ(dataset.depth_scale.units_per_metre, 5000);
  EXPECT_FALSE(dataset.depth_scale.is_assumed);
  const synth::SyntheticSequence sequence = synth::make_sequence(
      {.scene = synth::SceneName::kBoxes, .frames = 5, .sensor = {}}, chosen.camera);
  for (const int index : {0, 4}) {
    const RgbdImage read = read_frame(dataset, static_cast<std::size_t>(index));
    const RgbdImage made = synth::make_frame(sequence, index);
    EXPECT_EQ(read.stamp, made.stamp);
    EXPECT_TRUE(test::same_bits(read.bgr, made.bgr));
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        EXPECT_EQ(std::isnan(read.depth(y, x)), std::isnan(made.depth(y, x)));
        if (std::isnan(made.depth(y, x))) continue;
        EXPECT_NEAR(read.depth(y, x), made.depth(y, x), 0.5 / 5000 + 1e-6);
      }
  }
  ASSERT_TRUE(dataset.ground_truth);
  const Trajectory truth = read_trajectory(*dataset.ground_truth).trajectory;
  EXPECT_EQ(truth[3 * 4].stamp, dataset.frames[3].stamp);
  EXPECT_THAT(truth[3 * 4].world_from_camera,
              NearPose(synth::pose_of(sequence, 3).world_from_camera, 1e-8));
}

TEST(SynthCommand, WritesTheSameBytesForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const auto one = folder.path() / "one", two = folder.path() / "two";
  ASSERT_EQ(synth(one, "--threads 1").status, 0);
  ASSERT_EQ(synth(two, "--threads 2").status, 0);
  const std::string difference = fmt::format("diff -r {} {}", one.string(), two.string());
  EXPECT_EQ(std::system(difference.c_str()), 0);
}

TEST(SynthCommand, RefusesAFolderThatIsNotEmpty) {
  const TemporaryFolder folder;
  const auto keepsake = folder.write("notes.txt", "mine");
  const auto refused = synth(folder.path());
  EXPECT_EQ(refused.status, static_cast<int>(ErrorCode::kOutput));
  EXPECT_THAT(refused.output, HasSubstr("--force"));
  EXPECT_EQ(synth(folder.path(), "--force").status, 0);
  EXPECT_TRUE(std::filesystem::exists(keepsake));
}

TEST(SynthCommand, ReplacingASequenceLeavesNothingOfTheOldOne) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "room";
  ASSERT_EQ(synth(out).status, 0);
  ASSERT_EQ(synth(out, "--frames 2 --force").status, static_cast<int>(ErrorCode::kUsage));
  ASSERT_EQ(run_edvo("synth " + out.string() + " --size 160x120 --frames 2 --force 2>&1").status,
            0);
  const Dataset dataset = open_dataset(out);
  EXPECT_EQ(dataset.frames.size(), 2U);
  EXPECT_EQ(dataset.colour_count, 2U);
}

TEST(SynthCommand, TellsWhatItWroteAsOneJsonObject) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "room";
  const auto result =
      run_edvo("synth " + out.string() + " --size 64x48 --frames 31 --json 2>/dev/null");
  ASSERT_EQ(result.status, 0);
  const auto told = nlohmann::json::parse(result.output);
  EXPECT_EQ(told["frames"], 31);
  EXPECT_DOUBLE_EQ(told["seconds"], 1.0);
  EXPECT_GT(told["path_length_m"], 0.3);
}

TEST(SynthCommand, FollowsATrajectory) {
  const TemporaryFolder folder;
  std::string lines;
  for (int i = 0; i <= 20; ++i)
    lines += fmt::format("{} {} 0 1.2 -0.7 0 0 0.7\n", i * 0.05, 0.01 * i);
  const auto file = folder.write("path.txt", lines);
  const auto out = folder.path() / "room";
  ASSERT_EQ(run_edvo(fmt::format("synth {} --size 64x48 --trajectory {} 2>&1", out.string(),
                                 file.string()))
                .status,
            0);
  const Trajectory truth = read_trajectory(out / "groundtruth.txt").trajectory;
  const SE3 moved = inverse(truth.front().world_from_camera) * truth.back().world_from_camera;
  EXPECT_NEAR(moved.translation.norm(), 0.2, 1e-6);
  EXPECT_NEAR(rotation_angle(moved), 0, 1e-6);
}

TEST(SynthCommand, NamesTheMistakeAndExitsWithItsCode) {
  const TemporaryFolder folder;
  const auto out = folder.path() / "room";
  const auto expect = [&](const std::string& arguments, ErrorCode code, const std::string& says) {
    const auto result = run_edvo(fmt::format("synth {} {} 2>&1", out.string(), arguments));
    EXPECT_EQ(result.status, static_cast<int>(code)) << arguments;
    EXPECT_THAT(result.output, HasSubstr(says)) << arguments;
    EXPECT_FALSE(std::filesystem::exists(out)) << arguments;
  };
  expect("--scene moon", ErrorCode::kUsage, "expected one of desk|office");
  expect("--frames 0", ErrorCode::kUsage, "out of range");
  expect("--size 640", ErrorCode::kUsage, "WIDTHxHEIGHT");
  expect("--depth-nois 0.1", ErrorCode::kUsage, "--depth-noise");
  expect("--trajectory /nowhere.txt", ErrorCode::kInput, "/nowhere.txt");
  expect("--camera /nowhere.toml", ErrorCode::kCalibration, "/nowhere.toml");
}

}  // namespace
}  // namespace edvo
