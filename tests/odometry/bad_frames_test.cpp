// SPDX-License-Identifier: MIT
// Frames that show something else must not move the world.
#include "edvo/odometry/odometry.hpp"
#include "support/matchers.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <opencv2/imgproc.hpp>
#include <string>

namespace edvo {
namespace {

constexpr int kFrames = 30;

const synth::SyntheticSequence& room() {
  static const auto sequence = test::make_sequence({.frames = kFrames}, test::kQvgaCamera);
  return sequence;
}

// Rendered once for all tests.
RgbdImage room_image(int i) {
  static std::map<int, RgbdImage> images;
  const auto [image, is_new] = images.try_emplace(i);
  if (is_new) image->second = synth::make_frame(room(), i);
  return image->second;
}

RgbdImage noise(RgbdImage image) {
  image.bgr = cv::Mat_<cv::Vec3b>(image.bgr.size());
  cv::RNG random(std::hash<std::string>{}(to_string(image.stamp)));  // no two alike
  random.fill(image.bgr, cv::RNG::UNIFORM, 0, 256);
  return image;
}

RgbdImage filled(RgbdImage image, int grey) {
  image.bgr = cv::Mat_<cv::Vec3b>(image.bgr.size(), cv::Vec3b::all(static_cast<uchar>(grey)));
  return image;
}

using Fault = std::function<RgbdImage(const RgbdImage&)>;

struct Tracked {
  std::vector<FrameResult> results;
  Trajectory trajectory;
};

// The room with frames [begin, end) replaced, or left out where there is no fault.
Tracked track_room(int begin, int end, const Fault& fault) {
  Odometry odometry(room().camera, preset(Method::kCannyCorner));
  Tracked all;
  for (int i = 0; i < kFrames; ++i) {
    const RgbdImage image = room_image(i);
    const bool is_bad = i >= begin && i < end;
    if (is_bad && !fault) continue;
    all.results.push_back(odometry.process(is_bad ? fault(image) : image));
  }
  odometry.finish();
  all.trajectory = odometry.trajectory();
  return all;
}

struct BadFrames {
  const char* name;
  int count;
  Fault fault;

  friend void PrintTo(const BadFrames& bad, std::ostream* out) { *out << bad.name; }
};

class BadFramesTest : public testing::TestWithParam<BadFrames> {};

TEST_P(BadFramesTest, EndWhereTheRunWithoutThemEnds) {
  const BadFrames& bad = GetParam();
  constexpr int kBegin = 10;
  const Tracked missing = track_room(kBegin, kBegin + bad.count, nullptr);
  const Tracked with = track_room(kBegin, kBegin + bad.count, bad.fault);
  ASSERT_TRUE(is_tracked(with.results.back().status));
  EXPECT_EQ(with.results.back().segment, 0);
  EXPECT_THAT(with.trajectory.back().world_from_camera,
              test::NearPose(missing.trajectory.back().world_from_camera, 2e-3));
  for (int i = kBegin; i < kBegin + bad.count; ++i)
    EXPECT_FALSE(is_tracked(with.results[static_cast<std::size_t>(i)].status)) << i;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, BadFramesTest,
    testing::Values(
        BadFrames{"OneNoise", 1, noise}, BadFrames{"FourNoise", 4, noise},
        BadFrames{"EightBlack", 8, [](const RgbdImage& image) { return filled(image, 0); }},
        BadFrames{"EightWhite", 8, [](const RgbdImage& image) { return filled(image, 255); }}),
    [](const testing::TestParamInfo<BadFrames>& test_case) { return test_case.param.name; });

TEST(BadFrames, AForeignImageIsLostAndChangesNothing) {
  const auto elsewhere =
      test::make_sequence({.scene = synth::SceneName::kCorridor, .frames = 1}, test::kQvgaCamera);
  const RgbdImage foreign = synth::make_frame(elsewhere, 0);
  const Fault fault = [&](const RgbdImage& image) {
    RgbdImage other = foreign;
    other.stamp = image.stamp;
    return other;
  };
  const Tracked missing = track_room(12, 13, nullptr), with = track_room(12, 13, fault);
  EXPECT_EQ(with.results[12].status, FrameStatus::kLost);
  EXPECT_NE(with.results[12].loss_cause, LossCause::kNone);
  ASSERT_EQ(with.trajectory.size(), missing.trajectory.size());
  EXPECT_THAT(with.trajectory.back().world_from_camera,
              test::NearPose(missing.trajectory.back().world_from_camera, 1e-3));
}

TEST(BadFrames, AnotherPlaceBeginsASegmentWithAGuessedPose) {
  const auto elsewhere = test::make_sequence(
      {.scene = synth::SceneName::kCorridor, .frames = kFrames}, test::kQvgaCamera);
  Odometry odometry(room().camera, preset(Method::kCannyCorner));
  FrameResult last_good;
  for (int i = 0; i < 8; ++i) last_good = odometry.process(room_image(i));
  std::vector<FrameResult> after;
  for (int i = 8; i < 16; ++i) after.push_back(odometry.process(synth::make_frame(elsewhere, i)));
  const auto restart = std::ranges::find(after, FrameStatus::kRestarted, &FrameResult::status);
  ASSERT_NE(restart, after.end());
  EXPECT_EQ(restart->segment, 1);
  EXPECT_THAT(restart->world_from_camera, test::NearPose(last_good.world_from_camera, 1e-9));
  EXPECT_EQ(after.back().status, FrameStatus::kTracked);
  EXPECT_EQ(after.back().segment, 1);
  // Back in the first room, the first segment goes on.
  const FrameResult back = odometry.process(room_image(16));
  EXPECT_EQ(back.status, FrameStatus::kRelocalized);
  EXPECT_EQ(back.segment, 0);
}

TEST(BadFrames, ConstantDepthIsNone) {
  Odometry odometry(room().camera, preset(Method::kCannyCorner));
  for (int i = 0; i < 4; ++i) {
    RgbdImage image = room_image(i);
    image.depth = cv::Mat_<float>(image.depth.size(), 1.5F);
    const FrameResult result = odometry.process(image);
    EXPECT_EQ(result.status, FrameStatus::kLost) << i;
    EXPECT_EQ(result.loss_cause, LossCause::kConstantDepth) << i;
  }
  EXPECT_EQ(odometry.process(room_image(4)).status, FrameStatus::kFirst);
}

// Spots of strong texture, the same in every image.
void paint(RgbdImage& image, const cv::Rect& where) {
  static const cv::Mat_<cv::Vec3b> kSpots = [] {
    cv::Mat_<cv::Vec3b> small(60, 80), spots;
    cv::RNG random(5);
    random.fill(small, cv::RNG::UNIFORM, 0, 256);
    cv::resize(small, spots, {}, 4, 4);
    return spots;
  }();
  cv::Mat_<cv::Vec3b> bgr = image.bgr.clone();
  for (int y = where.y; y < where.y + where.height; ++y)
    for (int x = where.x; x < where.x + where.width; ++x)
      bgr(y, x) = kSpots(y % kSpots.rows, x % kSpots.cols);
  image.bgr = bgr;
}

// Each tracked frame is within 10 cm and 5 degrees, relative to the first one of its segment; most
// are tracked.
void expect_none_wrong(const std::function<RgbdImage(int)>& image_at) {
  Odometry odometry(room().camera, preset(Method::kCannyCorner));
  std::map<int, std::pair<SE3, SE3>> first;  // of each segment, estimated and true
  int tracked = 0;
  for (int i = 0; i < kFrames; ++i) {
    const FrameResult result = odometry.process(image_at(i));
    if (result.status == FrameStatus::kLost) continue;
    const SE3 truth = synth::pose_of(room(), i).world_from_camera;
    const auto& [pose, true_pose] =
        first.try_emplace(result.segment, result.world_from_camera, truth).first->second;
    const SE3 error =
        inverse(inverse(true_pose) * truth) * inverse(pose) * result.world_from_camera;
    EXPECT_LT(error.translation.norm(), 0.1) << i;
    EXPECT_LT(rotation_angle(error), 0.087) << i;
    tracked += result.status == FrameStatus::kTracked ? 1 : 0;
  }
  EXPECT_GT(tracked, kFrames * 3 / 4);
}

TEST(BadFrames, DirtOnTheLensIsNotFollowed) {
  expect_none_wrong([](int i) {
    RgbdImage image = room_image(i);
    paint(image, {0, 0, image.bgr.cols * 3 / 10, image.bgr.rows});
    return image;
  });
}

TEST(BadFrames, WhatTheCameraCarriesIsNotFollowed) {
  expect_none_wrong([](int i) {
    RgbdImage image = room_image(i);
    const cv::Rect carried(0, image.bgr.rows / 2, image.bgr.cols * 6 / 10, image.bgr.rows / 2);
    paint(image, carried);
    image.depth = image.depth.clone();
    image.depth(carried).setTo(0.5F);
    return image;
  });
}

}  // namespace
}  // namespace edvo
