// SPDX-License-Identifier: MIT
// Maps through the program: saved, described, exported, found again, extended, merged, refused.
#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "support/program.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::ProgramResult;
using test::run_edvo;
using ::testing::HasSubstr;

constexpr int kMapStatus = static_cast<int>(ErrorCode::kMap);

// A rendered room and the map of its first half, made once.
class MapCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::TemporaryFolder;
    const std::string synth =
        "synth " + place("room") + " --path orbit --scene office --seed 1 --rate 6 --frames 60";
    ASSERT_EQ(run_edvo(synth + " >/dev/null 2>&1").status, 0);
    const ProgramResult made = run("--max-frames 40 --save-map " + place("room.map"));
    ASSERT_EQ(made.status, 0) << made.output;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string place(const std::string& name) { return (folder_->path() / name).string(); }

  static ProgramResult run(const std::string& arguments) {
    return run_edvo("run " + place("room") + " -o " + place("out") +
                    " --force --quiet --no-report " + arguments + " 2>&1");
  }

  static test::TemporaryFolder* folder_;
};

test::TemporaryFolder* MapCommand::folder_ = nullptr;

TEST_F(MapCommand, InfoSaysWhatAMapHolds) {
  const ProgramResult result = run_edvo("map info " + place("room.map") + " --json");
  ASSERT_EQ(result.status, 0);
  const json info = json::parse(result.output);
  EXPECT_EQ(info["camera"]["width"], 640);
  EXPECT_EQ(info["depth_scale"], 5000);
  EXPECT_EQ(info["colour"], true);
  EXPECT_GE(info["keyframes"], 5);
  EXPECT_EQ(info["segments"].size(), 1u);
  EXPECT_THAT(run_edvo("map info " + place("room.map")).output, HasSubstr("640 x 480"));
}

TEST_F(MapCommand, ExportsMeshPointsGridAndTrajectory) {
  const ProgramResult result =
      run_edvo("map export " + place("room.map") + " --mesh " + place("mesh.ply") + " --points " +
               place("points.ply") + " --grid " + place("grid.pgm") + " --trajectory " +
               place("keyframes.tum") + " --voxel 0.03 2>&1");
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(read_file(place("mesh.ply")), HasSubstr("element face"));
  EXPECT_THAT(read_file(place("points.ply")), HasSubstr("element vertex"));
  EXPECT_TRUE(fs::exists(place("grid.yaml")));
  EXPECT_GE(read_trajectory(place("keyframes.tum")).trajectory.size(), 5u);
}

TEST_F(MapCommand, ExportRefusesNumbersAndNamesThatMakeNoSense) {
  const auto refuses = [](const std::string& arguments, const std::string& part, int status) {
    const ProgramResult result =
        run_edvo("map export " + place("room.map") + " " + arguments + " 2>&1");
    EXPECT_EQ(result.status, status) << arguments;
    EXPECT_THAT(result.output, HasSubstr(part));
  };
  const std::string grid = "--grid " + place("no.pgm"), mesh = "--mesh " + place("no.ply");
  refuses(grid + " --floor nan", "nan", 2);
  refuses(grid + " --lowest 2 --highest 1", "nothing is between", 2);
  refuses(mesh + " --voxel nan", "nan", 2);
  refuses(mesh + " --points " + place("no.ply"), "give two names", 2);
  refuses("--mesh \"\"", "empty", 2);
  refuses("--mesh " + place("none/no.ply"), "there is no folder", 7);
  refuses("--trajectory " + place(""), "is a folder", 7);
  EXPECT_FALSE(fs::exists(place("no.ply")) || fs::exists(place("no.pgm")));
}

TEST_F(MapCommand, OutputsOfARunAreCheckedBeforeIt) {
  for (const std::string& output : {"--points " + place("none/p.ply"), "--save-map " + place(""),
                                    "--save-map " + place("none/m.map")}) {
    const ProgramResult result = run(output);
    EXPECT_EQ(result.status, 7) << output;
    EXPECT_THAT(result.output, Not(HasSubstr("frames")));
  }
  EXPECT_EQ(run("--save-map \"\"").status, 2);
}

TEST_F(MapCommand, WritesTheMapThroughALinkAndAlsoWherePointsFail) {
  fs::copy_file(place("room.map"), place("target.map"));
  fs::create_symlink("target.map", place("link.map"));
  const ProgramResult result =
      run("--max-frames 5 --points /dev/full --save-map " + place("link.map"));
  EXPECT_EQ(result.status, 7) << result.output;
  EXPECT_THAT(result.output, HasSubstr("/dev/full"));
  EXPECT_TRUE(fs::is_symlink(place("link.map")));
  EXPECT_LT(fs::file_size(place("target.map")), fs::file_size(place("room.map")));
}

TEST_F(MapCommand, TheSecondHalfIsFoundInTheMapOfTheFirst) {
  const ProgramResult result = run("--start 40 --json --map " + place("room.map"));
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_EQ(json::parse(result.output)["map"]["localized_frames"], 20);
  EXPECT_TRUE(fs::exists(place("out") + "/map_links.jsonl"));
  std::istringstream frames(read_file(place("out") + "/localization.jsonl"));
  std::string line;
  int localized = 0;
  while (std::getline(frames, line)) localized += json::parse(line)["localized"] == true ? 1 : 0;
  EXPECT_EQ(localized, 20);
  // In the map's frame, which is that of the sequence's first camera.
  const Trajectory truth = read_trajectory(place("room") + "/groundtruth.txt").trajectory;
  const SE3 map_from_world = inverse(truth.front().world_from_camera);
  for (const StampedPose& pose : read_trajectory(place("out") + "/trajectory.tum").trajectory)
    for (const StampedPose& real : truth) {
      if (real.stamp != pose.stamp) continue;
      const SE3 expected = map_from_world * real.world_from_camera;
      EXPECT_LT((expected.translation - pose.world_from_camera.translation).norm(), 0.03);
    }
}

TEST_F(MapCommand, UpdatingAddsTheRunsKeyframes) {
  fs::copy_file(place("room.map"), place("grown.map"));
  const auto keyframes = [&] {
    return json::parse(run_edvo("map info --json " + place("grown.map")).output)["keyframes"]
        .get<int>();
  };
  const int before = keyframes();
  ASSERT_EQ(run("--start 40 --update-map --map " + place("grown.map")).status, 0);
  EXPECT_GT(keyframes(), before);
  EXPECT_FALSE(fs::exists(place("grown.map.lock")));
}

TEST_F(MapCommand, MergesMapsThatOverlapAndNoOthers) {
  ASSERT_EQ(run("--start 30 --save-map " + place("second.map")).status, 0);
  const std::string merge =
      "map merge " + place("room.map") + " " + place("second.map") + " -o " + place("both.map");
  const ProgramResult merged = run_edvo(merge + " 2>&1");
  ASSERT_EQ(merged.status, 0) << merged.output;
  const std::string synth =
      "synth " + place("other") + " --path orbit --scene boxes --seed 2 --rate 6 --frames 20";
  ASSERT_EQ(run_edvo(synth + " >/dev/null 2>&1").status, 0);
  const std::string other =
      "run " + place("other") + " -o " + place("out") + " --force --quiet --no-report ";
  ASSERT_EQ(run_edvo(other + "--save-map " + place("other.map") + " >/dev/null 2>&1").status, 0);
  const ProgramResult apart = run_edvo("map merge " + place("room.map") + " " + place("other.map") +
                                       " -o " + place("none.map") + " 2>&1");
  EXPECT_EQ(apart.status, kMapStatus);
  EXPECT_THAT(apart.output, HasSubstr("shows no place"));
  EXPECT_FALSE(fs::exists(place("none.map")));

  const ProgramResult lost = run_edvo(other + "--map " + place("room.map") + " 2>&1");
  EXPECT_EQ(lost.status, kMapStatus);
  EXPECT_THAT(lost.output, HasSubstr("no part of this run was found in the map"));
}

TEST_F(MapCommand, RefusesADamagedMapAndAnotherCamera) {
  std::string bytes = read_file(place("room.map"));
  bytes[bytes.size() / 2] ^= 4;
  folder_->write("damaged.map", bytes);
  const ProgramResult damaged = run_edvo("map info " + place("damaged.map") + " 2>&1");
  EXPECT_EQ(damaged.status, kMapStatus);
  EXPECT_THAT(damaged.output, HasSubstr("(VIEW) of this map is damaged"));
  folder_->write("camera.txt", "500 500 320 240");
  const ProgramResult other =
      run("--camera " + place("camera.txt") + " --map " + place("room.map"));
  EXPECT_EQ(other.status, kMapStatus);
  EXPECT_THAT(other.output, HasSubstr("another camera"));
  const ProgramResult scale = run("--depth-scale 4900 --update-map --map " + place("room.map"));
  EXPECT_EQ(scale.status, kMapStatus);
  EXPECT_THAT(scale.output, HasSubstr("4900 depth units per metre"));
}

TEST_F(MapCommand, RefusesOptionsThatMakeNoSense) {
  const auto refuses = [](const std::string& arguments, const std::string& reason) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kUsage)) << arguments;
    EXPECT_THAT(result.output, HasSubstr(reason));
  };
  refuses("--update-map", "which map?");
  refuses("--no-loops --save-map x.map", "leave --no-loops out");
  refuses("--method origin --save-map x.map", "keeps no keyframes");
}

TEST_F(MapCommand, ReplacesNoFileUnasked) {
  constexpr int kOutputStatus = static_cast<int>(ErrorCode::kOutput);
  const auto track = [](const std::string& name, const std::string& flags) {
    fs::remove_all(place("fresh"));
    return run_edvo("run " + place("room") + " -o " + place("fresh") +
                    " --quiet --no-report --max-frames 8 --save-map " + place(name) + " " + flags +
                    " 2>&1");
  };
  folder_->write("notes.txt", "of weeks");
  for (const std::string flags : {"", "--force"}) {
    const ProgramResult result = track("notes.txt", flags);
    EXPECT_EQ(result.status, kOutputStatus) << flags;
    EXPECT_THAT(result.output, HasSubstr("notes.txt: is no map of edvo"));
    EXPECT_FALSE(fs::exists(place("fresh")));  // before anything is tracked
  }
  EXPECT_EQ(read_file(place("notes.txt")), "of weeks");

  const std::string old = read_file(place("room.map"));
  folder_->write("again.map", old);
  const ProgramResult refused = track("again.map", "");
  EXPECT_EQ(refused.status, kOutputStatus);
  EXPECT_THAT(refused.output, HasSubstr("replace it with --force"));
  EXPECT_EQ(read_file(place("again.map")), old);
  EXPECT_EQ(track("again.map", "--force").status, 0);
  EXPECT_NE(read_file(place("again.map")), old);

  const std::string both = place("room.map") + " " + place("again.map");
  const ProgramResult merged =
      run_edvo("map merge " + both + " -o " + place("again.map") + " 2>&1");
  EXPECT_EQ(merged.status, kOutputStatus) << merged.output;
}

TEST_F(MapCommand, ExportReplacesNoFileUnaskedAndWritesNoOtherFormat) {
  folder_->write("old.yaml", "image: other.pgm");
  const auto exported = [](const std::string& flags) {
    return run_edvo("map export " + place("room.map") + " " + flags + " 2>&1");
  };
  const ProgramResult grid = exported("--grid " + place("old.pgm"));
  EXPECT_EQ(grid.status, static_cast<int>(ErrorCode::kOutput));
  EXPECT_THAT(grid.output, HasSubstr("old.yaml: there is such a file"));
  EXPECT_FALSE(fs::exists(place("old.pgm")));
  EXPECT_EQ(exported("--force --grid " + place("old.pgm")).status, 0);
  for (const std::string flags :
       {"--mesh q.obj", "--mesh q.STL", "--points q.xyz", "--grid g.png", "--trajectory k.csv"}) {
    const ProgramResult result = exported(flags);
    EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kUsage)) << flags;
    EXPECT_THAT(result.output, HasSubstr("is not written here, only ."));
  }
}

TEST_F(MapCommand, MergesNoMapWithItself) {
  const ProgramResult result = run_edvo("map merge " + place("room.map") + " " + place(".") +
                                        "/room.map -o " + place("twice.map") + " 2>&1");
  EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(result.output, HasSubstr("is the same file as"));
  EXPECT_FALSE(fs::exists(place("twice.map")));
}

// A limit on the size of files stands for a full disk.
TEST_F(MapCommand, AMapThatDoesNotFitTheDiskLeavesTheOldOne) {
  fs::copy_file(place("room.map"), place("kept.map"));
  const std::string limit = "--version >/dev/null; ulimit -f 500; ";
  const ProgramResult full = run_edvo(
      limit + EDVO_PROGRAM + " run " + place("room") + " -o " + place("out") +
      " --force --quiet --no-report --max-frames 20 --save-map " + place("kept.map") + " 2>&1");
  EXPECT_EQ(full.status, static_cast<int>(ErrorCode::kOutput)) << full.output;
  EXPECT_THAT(full.output, HasSubstr("kept.map"));
  EXPECT_EQ(read_file(place("kept.map")), read_file(place("room.map")));
}

TEST_F(MapCommand, TheSecondProgramThatWritesAMapIsRefused) {
  const std::string lock = "flock --exclusive " + place("busy.map.lock") + " ";
  const ProgramResult second = run_edvo(
      "--version >/dev/null; " + lock + EDVO_PROGRAM + " run " + place("room") + " -o " +
      place("out") + " --force --quiet --no-report --save-map " + place("busy.map") + " 2>&1");
  EXPECT_EQ(second.status, kMapStatus) << second.output;
  EXPECT_THAT(second.output, HasSubstr("another program is about to write this map"));
}

}  // namespace
}  // namespace edvo
