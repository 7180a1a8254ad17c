// SPDX-License-Identifier: MIT
#include "edvo/odometry/keyframe_corners.hpp"

#include "support/matchers.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

synth::SyntheticSequence room(synth::SceneName scene) {
  return test::make_sequence({.scene = scene, .seed = 1, .frames = 60}, test::kQvgaCamera);
}

Frame frame_of(const synth::SyntheticSequence& sequence, int index) {
  return make_frame(synth::make_frame(sequence, index), make_undistortion({test::kQvgaCamera, {}}));
}

TEST(KeyframeCorners, TellAMotionThatNothingForetold) {
  const synth::SyntheticSequence office = room(synth::SceneName::kOffice);
  const SE3 truth =
      inverse(pose_of(office, 25).world_from_camera) * pose_of(office, 0).world_from_camera;
  KeyframeCorners corners(frame_of(office, 0));
  const std::optional<SE3> found = corners.motion_to(frame_of(office, 25));
  ASSERT_TRUE(found);
  // A guess: compilers round differently, and RANSAC then keeps other corners.
  EXPECT_THAT(*found, test::NearPose(truth, 0.06));
}

TEST(KeyframeCorners, TellNothingOfAnotherPlace) {
  KeyframeCorners corners(frame_of(room(synth::SceneName::kOffice), 0));
  EXPECT_FALSE(corners.motion_to(frame_of(room(synth::SceneName::kLivingRoom), 25)));
}

TEST(KeyframeCorners, TellNothingWithoutAKeyframe) {
  EXPECT_FALSE(KeyframeCorners{}.motion_to(frame_of(room(synth::SceneName::kOffice), 0)));
}

}  // namespace
}  // namespace edvo
