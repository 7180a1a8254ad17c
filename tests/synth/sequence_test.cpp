// SPDX-License-Identifier: MIT
#include "edvo/synth/sequence.hpp"

#include "edvo/core/error.hpp"
#include "support/matchers.hpp"
#include "support/same_bits.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo::synth {
namespace {

using test::NearPose;
using test::same_bits;

constexpr DistortedCamera kSmall{
    .pinhole = {.fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5, .width = 160, .height = 120}};

bool same(const RgbdImage& a, const RgbdImage& b) {
  return a.stamp == b.stamp && same_bits(a.bgr, b.bgr) && same_bits(a.depth, b.depth);
}

// Everything that makes noise.
SequenceOptions rough() {
  SequenceOptions options;
  options.moving = MovingThing::kBox;
  options.exposure_time = 0.02;
  options.sensor.missing_share = 0.1;
  options.sensor.depth_correlation = 1;
  return options;
}

TEST(SyntheticSequence, FramesAreTheSameInAnyOrderAndForAnyNumberOfThreads) {
  SyntheticSequence one = make_sequence(rough(), kSmall), many = make_sequence(rough(), kSmall);
  one.threads = 1;
  many.threads = 3;
  std::vector<RgbdImage> forward;
  for (const int index : {0, 7, 150}) forward.push_back(make_frame(one, index));
  EXPECT_TRUE(same(make_frame(many, 150), forward[2]));
  EXPECT_TRUE(same(make_frame(many, 7), forward[1]));
  EXPECT_TRUE(same(make_frame(one, 0), forward[0]));
}

TEST(SyntheticSequence, AnotherSeedGivesOtherFrames) {
  SequenceOptions options;
  const RgbdImage first = make_frame(make_sequence(options, kSmall), 3);
  options.seed = 1;
  EXPECT_FALSE(same(first, make_frame(make_sequence(options, kSmall), 3)));
}

TEST(SyntheticSequence, DefaultFramesAreVgaWithDepthAlmostEverywhere) {
  const RgbdImage image = make_frame(make_sequence({}), 0);
  EXPECT_EQ(image.bgr.size(), cv::Size(640, 480));
  EXPECT_EQ(image.depth.size(), cv::Size(640, 480));
  int with_depth = 0;
  for (const float z : image.depth) {
    if (std::isnan(z)) continue;
    ++with_depth;
    EXPECT_GE(z, 0.4F);
    EXPECT_LE(z, 5.0F);
  }
  EXPECT_GT(with_depth, 0.8 * 640 * 480);
}

TEST(SyntheticSequence, GroundTruthHoldsEveryFramesPoseAtItsStamp) {
  const SyntheticSequence sequence = make_sequence({.frames = 20}, kSmall);
  const Trajectory truth = ground_truth(sequence);
  ASSERT_EQ(truth.size(), 19 * 4 + 1U);
  for (std::size_t i = 1; i < truth.size(); ++i) EXPECT_LT(truth[i - 1].stamp, truth[i].stamp);
  for (int index = 0; index < frame_count(sequence); ++index) {
    EXPECT_EQ(truth[4 * index].stamp, pose_of(sequence, index).stamp);
    EXPECT_THAT(truth[4 * index].world_from_camera,
                NearPose(pose_of(sequence, index).world_from_camera, 1e-12));
  }
  EXPECT_EQ(make_frame(sequence, 5).stamp, truth[20].stamp);
}

TEST(SyntheticSequence, LateDepthIsThatOfAnEarlierTime) {
  SequenceOptions options;
  options.sensor.noise = false;
  const SyntheticSequence exact = make_sequence(options, kSmall);
  options.sensor = {};
  options.sensor.depth_delay = 0.1;  // three frames
  options.sensor.disparity_step = options.sensor.depth_noise = 0;
  options.sensor.depth_edge_jitter = 0;
  const RgbdImage late = make_frame(make_sequence(options, kSmall), 10);
  const auto far_off = [&](int index) {
    cv::Mat_<float> difference;
    cv::absdiff(late.depth, make_frame(exact, index).depth, difference);
    return cv::countNonZero(difference > 1e-4F);
  };
  EXPECT_LT(far_off(7), 20);
  EXPECT_GT(far_off(10), 5000);
}

TEST(SyntheticSequence, DroppedFramesLeaveGapsButTheFirstStays) {
  const SyntheticSequence sequence =
      make_sequence({.frames = 400, .dropped_share = 0.25, .sensor = {}}, kSmall);
  EXPECT_NEAR(frame_count(sequence), 300, 30);
  EXPECT_EQ(sequence.kept.front(), 0);
  const SyntheticSequence whole = make_sequence({.frames = 400, .sensor = {}}, kSmall);
  EXPECT_TRUE(same(make_frame(sequence, 10), make_frame(whole, sequence.kept[10])));
}

// Share of pixels that differ visibly between two options at a frame.
double changed(const SequenceOptions& a, const SequenceOptions& b, int index) {
  const RgbdImage one = make_frame(make_sequence(a, kSmall), index);
  const RgbdImage two = make_frame(make_sequence(b, kSmall), index);
  int count = 0;
  for (int y = 0; y < one.bgr.rows; ++y)
    for (int x = 0; x < one.bgr.cols; ++x)
      if (cv::norm(one.bgr(y, x), two.bgr(y, x), cv::NORM_INF) > 3) ++count;
  return count / static_cast<double>(one.bgr.total());
}

SequenceOptions exact(MovingThing moving, double share = 0.25) {
  SequenceOptions options{.frames = 121, .moving = moving, .moving_share = share, .sensor = {}};
  options.sensor.noise = false;
  return options;
}

// Share of the image that is hidden at a frame.
double hidden(const SequenceOptions& moving, int index) {
  SequenceOptions alone = moving;
  alone.moving = MovingThing::kNone;
  return changed(moving, alone, index);
}

TEST(SyntheticSequence, MovingBoxCrossesTheImageAndHidesItsShare) {
  for (const double share : {0.25, 0.5, 0.75, 0.95}) {
    const SequenceOptions options = exact(MovingThing::kBox, share);
    EXPECT_NEAR(hidden(options, 60), share, 0.05);
    EXPECT_NEAR(hidden(options, 0), 0, 0.02);
    EXPECT_NEAR(hidden(options, 120), 0, 0.02);
  }
}

TEST(SyntheticSequence, PersonCrossesTheImageAndHidesItsShare) {
  for (const double share : {0.15, 0.25, 0.4}) {
    const SequenceOptions options = exact(MovingThing::kPerson, share);
    EXPECT_NEAR(hidden(options, 60), share, 0.07);
    EXPECT_NEAR(hidden(options, 0), 0, 0.02);
    EXPECT_NEAR(hidden(options, 120), 0, 0.02);
  }
}

TEST(SyntheticSequence, TurntableTurnsInPlaceBeforeAStillCamera) {
  for (const double share : {0.25, 0.5, 0.95}) {
    SequenceOptions options = exact(MovingThing::kTurntable, share);
    options.path = PathName::kStill;
    const SyntheticSequence sequence = make_sequence(options, kSmall);
    const SE3 start = pose_of(sequence, 0).world_from_camera;
    for (const int index : {0, 30, 100}) {
      EXPECT_NEAR(hidden(options, index), share, 0.13) << share << " " << index;
      EXPECT_THAT(pose_of(sequence, index).world_from_camera, NearPose(start, 1e-12));
    }
    // 45 degrees turn a square column's side away.
    const RgbdImage before = make_frame(sequence, 0), after = make_frame(sequence, 30);
    cv::Mat_<float> difference;
    cv::absdiff(before.depth, after.depth, difference);
    EXPECT_GT(cv::countNonZero(difference > 0.02F), 0.3 * share * 160 * 120);
  }
}

TEST(SyntheticSequence, ExposureTimeBlursMotion) {
  SequenceOptions sharp = exact(MovingThing::kNone), blurred = sharp;
  blurred.exposure_time = 0.1;
  const auto contrast = [](const SequenceOptions& options) {
    const RgbdImage image = make_frame(make_sequence(options, kSmall), 40);
    double sum = 0;
    for (int y = 0; y < image.bgr.rows; ++y)
      for (int x = 1; x < image.bgr.cols; ++x)
        sum += std::abs(image.bgr(y, x)[1] - image.bgr(y, x - 1)[1]);
    return sum;
  };
  EXPECT_LT(contrast(blurred), 0.95 * contrast(sharp));
}

// The row at a share of the height is seen from where the camera is then; a Kinect's depth as well,
// that of others from where it is at the middle row.
TEST(SyntheticSequence, ReadoutTimeGivesEachRowItsOwnPose) {
  constexpr int kFrame = 40, kRow = 100;
  constexpr double kReadout = 0.1, kRate = 30, kRows = 120;
  for (const SensorKind kind : {SensorKind::kKinect1, SensorKind::kStereo}) {
    SequenceOptions at_once = exact(MovingThing::kNone);
    at_once.sensor.kind = kind;
    SequenceOptions rolling = at_once;
    rolling.readout_time = kReadout;
    const RgbdImage image = make_frame(make_sequence(rolling, kSmall), kFrame);
    // All rows at the time of that one: a frame of a faster camera.
    SequenceOptions fast = at_once;
    fast.rate = 1000;
    fast.frames = 2000;
    const double seconds = kFrame / kRate + ((kRow + 2) / kRows - 0.5) * kReadout;
    const RgbdImage then =
        make_frame(make_sequence(fast, kSmall), static_cast<int>(std::lround(seconds * fast.rate)));
    const RgbdImage middle = make_frame(make_sequence(at_once, kSmall), kFrame);
    const auto off = [&](const RgbdImage& other) {
      return cv::norm(image.bgr.row(kRow), other.bgr.row(kRow), cv::NORM_L1);
    };
    EXPECT_LT(off(then), 0.2 * off(middle));
    const auto depth_off = [&](const RgbdImage& other) {
      return cv::norm(image.depth.row(kRow), other.depth.row(kRow), cv::NORM_L1);
    };
    if (kind == SensorKind::kKinect1)
      EXPECT_LT(depth_off(then), 0.2 * depth_off(middle));
    else
      EXPECT_EQ(depth_off(middle), 0);
  }
}

TEST(SyntheticSequence, RecordedTrajectoryGivesTheLengthAndTheMotion) {
  Trajectory recorded;
  for (int i = 0; i <= 100; ++i)
    recorded.push_back({.stamp = stamp_from_seconds(50 + 0.01 * i),
                        .world_from_camera = look_at({0.003 * i, 0, 1}, {0.003 * i, 2, 1})});
  const SyntheticSequence sequence = make_sequence({}, kSmall, recorded);
  EXPECT_EQ(frame_count(sequence), 31);
  const SE3 moved =
      inverse(pose_of(sequence, 0).world_from_camera) * pose_of(sequence, 30).world_from_camera;
  EXPECT_THAT(moved, NearPose(SE3{.translation = {0.3, 0, 0}}, 1e-6));
}

TEST(SyntheticSequence, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW((void)make_sequence({.frames = 0, .sensor = {}}, kSmall), Error);
  SequenceOptions options;
  options.sensor.depth_noise = std::nan("");
  EXPECT_THROW((void)make_sequence(options, kSmall), Error);
}

TEST(SyntheticSequence, AnImpossibleCameraIsRefused) {
  DistortedCamera camera = kSmall;
  camera.pinhole.fx = 0;
  EXPECT_THROW((void)make_sequence({}, camera), Error);
}

}  // namespace
}  // namespace edvo::synth
