// SPDX-License-Identifier: MIT
// What goes wrong in front of real cameras, one condition at a time, on rendered sequences. Bounds
// are some times the errors seen; each condition is one rendering (docs/evaluation.md).
#include "edvo/odometry/odometry.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace edvo {
namespace {

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
    const FrameReport report = odometry.process(synth::make_frame(sequence, i));
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
  expect_all_tracked(follow(options), 45, 0.031);
}

TEST(BadConditions, AnExposureJumpIsTracked) {
  for (const double jump : {0.6, 1.5}) {
    SequenceOptions options{.frames = 45, .sensor = {}};
    options.sensor.exposure_jump = jump;
    options.sensor.exposure_jump_time = 0.7;
    expect_all_tracked(follow(options), 45, 0.028);
  }
}

TEST(BadConditions, BlurIsTracked) {
  expect_all_tracked(follow({.frames = 40, .exposure_time = 0.02, .sensor = {}}), 40, 0.034);
}

TEST(BadConditions, TenDroppedFramesAreBridged) {
  std::set<int> dropped;
  for (int i = 20; i < 30; ++i) dropped.insert(i);
  expect_all_tracked(follow({.frames = 50, .sensor = {}}, test::kQvgaCamera, dropped), 40, 0.031);
}

TEST(BadConditions, ABoxThatMovesAcrossAQuarterOfTheImageIsNotFollowed) {
  expect_all_tracked(follow({.frames = 90, .moving_box = true, .sensor = {}}), 90, 0.058);
}

TEST(BadConditions, NorIsABoxThatIsBlurred) {
  expect_all_tracked(
      follow({.frames = 70, .exposure_time = 0.015, .moving_box = true, .sensor = {}}), 70, 0.1);
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
    const FrameReport report = odometry.process(image);
    ASSERT_NE(report.status, FrameStatus::kLost) << i;
    worst = std::max(worst, report.world_from_camera.translation.norm());
  }
  testing::Test::RecordProperty("worst_mm", static_cast<int>(std::lround(1000 * worst)));
  EXPECT_LT(worst, 0.005);
}

}  // namespace
}  // namespace edvo
