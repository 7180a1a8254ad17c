// SPDX-License-Identifier: MIT
#include "edvo/odometry/readout_time.hpp"

#include "edvo/odometry/odometry.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace edvo {
namespace {

using synth::SequenceOptions;

// Frames that see so much of the difference between the estimate and the truth, with noise.
ReadoutTime after(int frames, double truth, double seen, double noise) {
  std::mt19937 random(5);
  std::normal_distribution<double> error(0, noise);
  ReadoutTime readout;
  for (int i = 0; i < frames; ++i) {
    const double now = readout.seconds();
    readout.observe({.seconds = now + seen * (truth - now) + error(random), .information = 1e6});
  }
  return readout;
}

TEST(ReadoutTime, IsFoundThoughEachFrameSeesAPartOfIt) {
  EXPECT_NEAR(after(400, 0.025, 0.35, 0.005).seconds(), 0.025, 0.003);
  EXPECT_NEAR(after(400, -0.025, 0.35, 0.005).seconds(), -0.025, 0.003);
}

TEST(ReadoutTime, OfAGlobalShutterIsZero) {
  for (int frames = 1; frames < 400; ++frames)
    ASSERT_EQ(after(frames, 0, 0.35, 0.005).seconds(), 0) << frames;
}

TEST(ReadoutTime, IsZeroWhileFewFramesHaveTold) {
  EXPECT_EQ(after(15, 0.025, 0.35, 0.005).seconds(), 0);
}

TEST(ReadoutTime, IgnoresFramesThatTellNothing) {
  ReadoutTime readout = after(100, 0.025, 0.35, 0.005);
  const double before = readout.seconds();
  for (int i = 0; i < 100; ++i) readout.observe({});
  EXPECT_EQ(readout.seconds(), before);
}

TEST(Velocity, IsThatOfTheMotionSinceTheLastGoodFrameUnlessThatIsLongAgo) {
  const SE3 last_from_ref = exp((Vector6d() << 0.1, 0, 0, 0, 0.2, 0).finished());
  const SE3 cur_from_last = exp((Vector6d() << -0.01, 0, 0.02, 0, 0.03, 0).finished());
  TrackingState last{.stamp = stamp_from_seconds(10.0),
                     .alignment = {.cur_from_ref = last_from_ref},
                     .motion_seconds = 0.1};
  const SE3 cur_from_ref = cur_from_last * last_from_ref;
  const Vector6d expected = log(inverse(cur_from_last)) / 0.1;
  EXPECT_LT((velocity_since(last, cur_from_ref, stamp_from_seconds(10.1)) - expected).norm(), 1e-9);
  EXPECT_TRUE(velocity_since(last, cur_from_ref, stamp_from_seconds(10.5)).isZero(0));
  EXPECT_TRUE(velocity_since({}, cur_from_ref, stamp_from_seconds(10.1)).isZero(0));
}

struct Tracked {
  double rpe = 0;      // rms of the relative errors of position over ten frames [m]
  double readout = 0;  // as known at the end [s]
  bool ever = false;   // whether it was known to be other than 0
};

Tracked track(const SequenceOptions& options, bool allow) {
  const synth::SyntheticSequence sequence = test::make_sequence(options, test::kQvgaCamera);
  Config config = preset(Method::kCannyCorner);
  config.tracking.rolling_shutter = allow;
  Odometry odometry({test::kQvgaCamera, {}}, config);
  Tracked tracked;
  for (int i = 0; i < synth::frame_count(sequence); ++i) {
    const FrameResult result = odometry.process(synth::make_frame(sequence, i));
    tracked.readout = result.readout_seconds;
    tracked.ever = tracked.ever || result.readout_seconds != 0;
  }
  odometry.finish();
  const Trajectory trajectory = odometry.trajectory();
  EXPECT_EQ(trajectory.size(), static_cast<std::size_t>(synth::frame_count(sequence)));
  constexpr std::size_t kApart = 10;
  double squares = 0;
  for (std::size_t i = kApart; i < trajectory.size(); ++i) {
    const auto pose = [&](std::size_t k) {
      return synth::pose_of(sequence, static_cast<int>(k)).world_from_camera;
    };
    const SE3 truth = inverse(pose(i - kApart)) * pose(i);
    const SE3 estimate =
        inverse(trajectory[i - kApart].world_from_camera) * trajectory[i].world_from_camera;
    squares += (inverse(truth) * estimate).translation.squaredNorm();
  }
  tracked.rpe = std::sqrt(squares / static_cast<double>(trajectory.size() - kApart));
  return tracked;
}

TEST(ReadoutTime, OfARenderedRollingShutterIsFoundAndAllowedFor) {
  const SequenceOptions options{.seed = 101, .frames = 150, .readout_time = 0.025, .sensor = {}};
  const Tracked with = track(options, true), without = track(options, false);
  EXPECT_NEAR(with.readout, 0.025, 0.005);
  EXPECT_EQ(without.readout, 0);
  EXPECT_LT(with.rpe, 0.6 * without.rpe);
}

// As if the camera hung upside down.
TEST(ReadoutTime, IsNegativeWhereTheLastRowComesFirst) {
  const SequenceOptions options{.path = synth::PathName::kXyz,
                                .seed = 106,
                                .frames = 120,
                                .readout_time = -0.025,
                                .sensor = {}};
  EXPECT_NEAR(track(options, true).readout, -0.025, 0.005);
}

TEST(ReadoutTime, OfARenderedGlobalShutterIsZeroThroughout) {
  for (const synth::SensorKind kind : {synth::SensorKind::kKinect1, synth::SensorKind::kTof}) {
    SequenceOptions options{.seed = 7, .frames = 90, .sensor = {}};
    options.sensor.kind = kind;
    EXPECT_FALSE(track(options, true).ever);
  }
}

}  // namespace
}  // namespace edvo
