// SPDX-License-Identifier: MIT
#include "edvo/slam/verify_link.hpp"

#include "support/matchers.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::NearPose;

// A frame of a rendered room as a keyframe whose points lie all over the image.
KeyframePtr keyframe_of(const synth::SyntheticSequence& sequence, int index) {
  const RgbdImage image = synth::make_frame(sequence, index);
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->id = index;
  keyframe->stamp = image.stamp;
  keyframe->bgr = image.bgr;
  keyframe->depth = image.depth;
  for (int y = 4; y < image.depth.rows - 4; y += 5)
    for (int x = 4; x < image.depth.cols - 4; x += 5)
      if (image.depth(y, x) > 0)
        keyframe->points.push_back({.position = back_project(test::kQvgaCamera, x, y,
                                                             static_cast<double>(image.depth(y, x)))
                                                    .cast<float>()});
  return keyframe;
}

KeyframeView view_of(const synth::SyntheticSequence& sequence, int index) {
  return make_view(keyframe_of(sequence, index), test::kQvgaCamera, {});
}

synth::SyntheticSequence office(int seed) {
  return test::make_sequence({.scene = synth::SceneName::kOffice, .seed = seed, .frames = 60},
                             test::kQvgaCamera);
}

SE3 motion_between(const synth::SyntheticSequence& sequence, int from, int to) {
  return inverse(pose_of(sequence, from).world_from_camera) *
         pose_of(sequence, to).world_from_camera;
}

TEST(VerifyLink, FindsTheMotionOfTwoViewsWithoutAGuess) {
  const synth::SyntheticSequence sequence = office(1);
  const LinkReport report =
      verify_link(view_of(sequence, 0), view_of(sequence, 25), std::nullopt, {}, {});
  EXPECT_EQ(report.status, LinkStatus::kAccepted) << name_of(report.status);
  EXPECT_GE(report.inliers, 12);
  EXPECT_THAT(report.from_pose_to, NearPose(motion_between(sequence, 0, 25), 0.01));
  EXPECT_TRUE(report.information.allFinite());
}

TEST(VerifyLink, GivesTheSameBitsTwice) {
  const synth::SyntheticSequence sequence = office(1);
  const KeyframeView from = view_of(sequence, 0), to = view_of(sequence, 25);
  const LinkReport a = verify_link(from, to, std::nullopt, {}, {});
  const LinkReport b = verify_link(from, to, std::nullopt, {}, {});
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.from_pose_to.translation, b.from_pose_to.translation);
  EXPECT_EQ(a.information, b.information);
}

TEST(VerifyLink, RefusesAnotherRoomAndSaysWhy) {
  const LinkReport report = verify_link(
      view_of(office(1), 0),
      view_of(test::make_sequence({.scene = synth::SceneName::kLivingRoom, .seed = 2, .frames = 60},
                                  test::kQvgaCamera),
              25),
      std::nullopt, {}, {});
  EXPECT_TRUE(report.status == LinkStatus::kFewMatches || report.status == LinkStatus::kNoMotion)
      << name_of(report.status);
}

// The same room with another wall between: what one view measured, the other looks through.
TEST(VerifyLink, RefusesAViewThroughWhatTheOtherMeasured) {
  const synth::SyntheticSequence sequence = office(1);
  const KeyframePtr exact = keyframe_of(sequence, 0);
  Keyframe changed = *exact;
  changed.id = 1;
  changed.depth = exact->depth.clone();
  for (int y = 60; y < 180; ++y)
    for (int x = 80; x < 240; ++x) changed.depth(y, x) *= 0.6F;
  const KeyframeView from = make_view(exact, test::kQvgaCamera, {});
  const KeyframeView to =
      make_view(std::make_shared<const Keyframe>(changed), test::kQvgaCamera, {});
  const LinkReport report = verify_link(from, to, SE3{}, {}, {});
  EXPECT_EQ(report.status, LinkStatus::kSeenThrough) << name_of(report.status);
  EXPECT_GT(report.seen_through, 0.05);
}

TEST(VerifyLink, RefusesAWrongGuess) {
  const synth::SyntheticSequence sequence = office(1);
  const SE3 wrong{.translation = {1.0, 0, 0.5}};
  const LinkReport report = verify_link(view_of(sequence, 0), view_of(sequence, 25), wrong, {}, {});
  EXPECT_NE(report.status, LinkStatus::kAccepted);
}

}  // namespace
}  // namespace edvo
