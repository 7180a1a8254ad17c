// SPDX-License-Identifier: MIT
// What goes wrong in front of real cameras, one condition at a time, on rendered sequences. Bounds
// are about twice the errors seen (docs/evaluation.md).
#include "edvo/odometry/odometry.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

namespace edvo {
namespace {

using synth::MovingThing;
using synth::PathName;
using synth::SceneName;
using synth::SequenceOptions;

constexpr double kWrong = 0.1;  // [m] a frame farther off must not be called tracked

struct Outcome {
  int tracked = 0, lost = 0;
  double worst = 0;           // position error of tracked frames [m]
  double worst_rotation = 0;  // [rad]
};

// Runs the default method; frames in `dropped` never arrive.
Outcome follow(const SequenceOptions& options, const Camera& camera = test::kQvgaCamera,
               const std::set<int>& dropped = {}) {
  const synth::SyntheticSequence sequence = test::make_sequence(options, camera);
  const SE3 start_from_world = inverse(synth::pose_of(sequence, 0).world_from_camera);
  Odometry odometry({camera, {}}, preset(Method::kCannyCorner));
  Outcome outcome;
  for (int i = 0; i < synth::frame_count(sequence); ++i) {
    if (dropped.contains(i)) continue;
    const FrameResult report = odometry.process(synth::make_frame(sequence, i));
    EXPECT_TRUE(is_finite(report.world_from_camera)) << i;
    if (report.status == FrameStatus::kLost) {
      ++outcome.lost;
      continue;
    }
    ++outcome.tracked;
    const SE3 truth = start_from_world * synth::pose_of(sequence, i).world_from_camera;
    const SE3 error = inverse(truth) * report.world_from_camera;
    EXPECT_LT(error.translation.norm(), kWrong) << i;
    outcome.worst = std::max(outcome.worst, error.translation.norm());
    outcome.worst_rotation = std::max(outcome.worst_rotation, rotation_angle(error));
  }
  testing::Test::RecordProperty("worst_mm", static_cast<int>(std::lround(1000 * outcome.worst)));
  return outcome;
}

void expect_all_tracked(const Outcome& outcome, int frames, double worst) {
  EXPECT_EQ(outcome.tracked, frames);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.worst, worst);
}

TEST(BadConditions, AThirdOfDepthMissingIsTracked) {
  SequenceOptions options{.frames = 45, .sensor = {}};
  options.sensor.missing_share = 0.3;
  expect_all_tracked(follow(options), 45, 0.014);
}

TEST(BadConditions, AnExposureJumpIsTracked) {
  for (const double jump : {0.6, 1.5}) {
    SequenceOptions options{.frames = 45, .sensor = {}};
    options.sensor.exposure_jump = jump;
    options.sensor.exposure_jump_time = 0.7;
    expect_all_tracked(follow(options), 45, 0.014);
  }
}

TEST(BadConditions, BlurIsTracked) {
  expect_all_tracked(follow({.frames = 40, .exposure_time = 0.02, .sensor = {}}), 40, 0.011);
}

TEST(BadConditions, TenDroppedFramesAreBridged) {
  std::set<int> dropped;
  for (int i = 20; i < 30; ++i) dropped.insert(i);
  expect_all_tracked(follow({.frames = 50, .sensor = {}}, test::kQvgaCamera, dropped), 40, 0.02);
}

TEST(BadConditions, ABoxThatMovesAcrossAQuarterOfTheImageIsNotFollowed) {
  expect_all_tracked(follow({.frames = 90, .moving = MovingThing::kBox, .sensor = {}}), 90, 0.025);
}

TEST(BadConditions, NorIsABoxThatIsBlurred) {
  expect_all_tracked(
      follow({.frames = 70, .exposure_time = 0.015, .moving = MovingThing::kBox, .sensor = {}}), 70,
      0.025);
}

// Frames called tracked would be wrong by up to 1.4 m in these if the box were followed.
struct BoxCase {
  const char* name;
  SequenceOptions options;
  double worst;  // [m]

  friend void PrintTo(const BoxCase& box_case, std::ostream* out) { *out << box_case.name; }
};

SequenceOptions box(SceneName scene, PathName path, int seed) {
  return {.scene = scene,
          .path = path,
          .seed = seed,
          .frames = 70,
          .moving = MovingThing::kBox,
          .sensor = {}};
}

SequenceOptions with_exposure_jump(SequenceOptions options) {
  options.sensor.exposure_jump = 1.5;
  options.sensor.exposure_jump_time = 1.1;
  return options;
}

class MovingBox : public testing::TestWithParam<BoxCase> {};

// A frame in which nothing tells the camera's motion from the box's may be lost.
TEST_P(MovingBox, IsNotFollowed) {
  const Outcome outcome = follow(GetParam().options);
  EXPECT_LE(outcome.lost, 1);
  EXPECT_EQ(outcome.tracked + outcome.lost, 70);
  EXPECT_LT(outcome.worst, GetParam().worst);
}

INSTANTIATE_TEST_SUITE_P(
    BadConditions, MovingBox,
    testing::Values(
        BoxCase{"OfficeSeed1", box(SceneName::kOffice, PathName::kDemo, 1), 0.047},
        BoxCase{"OfficeSeed21", box(SceneName::kOffice, PathName::kDemo, 21), 0.037},
        BoxCase{"OfficeOrbit", box(SceneName::kOffice, PathName::kOrbit, 0), 0.03},
        BoxCase{"OfficeXyz", box(SceneName::kOffice, PathName::kXyz, 0), 0.061},
        BoxCase{"OfficeTurn", box(SceneName::kOffice, PathName::kPureRotation, 0), 0.016},
        BoxCase{"OfficeExposureJump",
                with_exposure_jump(box(SceneName::kOffice, PathName::kDemo, 0)), 0.025},
        BoxCase{"LivingRoom", box(SceneName::kLivingRoom, PathName::kDemo, 0), 0.037},
        BoxCase{"LivingRoomSeed2", box(SceneName::kLivingRoom, PathName::kDemo, 2), 0.063},
        BoxCase{"LivingRoomOrbit", box(SceneName::kLivingRoom, PathName::kOrbit, 0), 0.042},
        BoxCase{"DeskXyz", box(SceneName::kDesk, PathName::kXyz, 0), 0.015},
        BoxCase{"Corridor", box(SceneName::kCorridor, PathName::kDemo, 0), 0.025},
        BoxCase{"BoxesOrbitSeed30", box(SceneName::kBoxes, PathName::kOrbit, 30), 0.022}),
    [](const auto& one) { return std::string(one.param.name); });

SequenceOptions turntable(SceneName scene, int seed, double share) {
  return {.scene = scene,
          .path = PathName::kStill,
          .seed = seed,
          .frames = 50,
          .moving = MovingThing::kTurntable,
          .moving_share = share,
          .sensor = {}};
}

TEST(BadConditions, ATurntableOverAQuarterOfTheImageDoesNotMoveAStillCamera) {
  for (const auto& [scene, seed] : {std::pair{SceneName::kLivingRoom, 1}, {SceneName::kBoxes, 3}})
    expect_all_tracked(follow(turntable(scene, seed, 0.25)), 50, 0.025);
}

TEST(BadConditions, NorDoesOneOverHalfOfItWhereItsFramesAreTracked) {
  const Outcome outcome = follow(turntable(SceneName::kBoxes, 3, 0.5));
  EXPECT_GE(outcome.tracked, 20);
  EXPECT_LT(outcome.worst, 0.05);
}

TEST(BadConditions, AWallWithoutTextureIsLost) {
  const Outcome outcome = follow({.scene = SceneName::kWall, .frames = 10, .sensor = {}});
  EXPECT_EQ(outcome.tracked, 0);
  EXPECT_EQ(outcome.lost, 10);
}

TEST(BadConditions, TurningOnTheSpotAtSixtyDegreesPerSecondIsTracked) {
  const Outcome outcome = follow({.path = PathName::kPureRotation, .frames = 60, .sensor = {}});
  expect_all_tracked(outcome, 60, 0.011);
  EXPECT_LT(outcome.worst_rotation, 0.0035);
}

// The view is rendered once; each of the 1800 frames has noise of its own.
TEST(BadConditions, StandingStillForAMinuteDriftsByLessThanFiveMillimetres) {
  const Camera camera = test::kQvgaCamera;
  const SequenceOptions options{.path = PathName::kStill, .sensor = {}};
  const synth::SyntheticSequence sequence = test::make_sequence(options, camera);
  const synth::Render exact = synth::render(
      sequence.scene, 0, synth::pose_of(sequence, 0).world_from_camera, sequence.rays, 1);
  Odometry odometry({camera, {}}, preset(Method::kCannyCorner));
  double worst = 0;  // [m]
  for (int i = 0; i < 1800; ++i) {
    const double seconds = i / options.rate;
    RgbdImage image = synth::sense(exact, options.sensor, camera.fx, seconds, 0,
                                   static_cast<std::uint64_t>(i), 1);
    image.stamp = stamp_from_seconds(seconds);
    const FrameResult report = odometry.process(image);
    ASSERT_NE(report.status, FrameStatus::kLost) << i;
    worst = std::max(worst, report.world_from_camera.translation.norm());
  }
  testing::Test::RecordProperty("worst_mm", static_cast<int>(std::lround(1000 * worst)));
  EXPECT_LT(worst, 0.005);
}

}  // namespace
}  // namespace edvo
