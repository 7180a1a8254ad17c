// SPDX-License-Identifier: MIT
#include "edvo/odometry/keyframe_policy.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

// A frame that fits well and has hardly moved.
AlignResult good() {
  AlignResult result;
  result.overlap = 1;
  result.inlier_ratio = 1;
  result.sigma = 5;
  return result;
}

constexpr KeyframeOptions kOptions{};
const TrackingState kState{.usual_sigma = 5, .keyframe_sharpness = 100, .frames_since_keyframe = 1};

TEST(KeyframePolicy, LeavesAGoodFrameAlone) {
  EXPECT_EQ(KeyframePolicy(kOptions).due(good(), {}, kState), std::nullopt);
}

TEST(KeyframePolicy, NamesTheReason) {
  const KeyframePolicy policy(kOptions);
  TrackingState old = kState;
  old.frames_since_keyframe = kOptions.period;
  EXPECT_EQ(policy.due(good(), {}, old), KeyframeReason::kPeriod);

  AlignResult moved = good();
  moved.alignment.cur_from_ref.translation.x() = kOptions.translation + 0.01;
  EXPECT_EQ(policy.due(moved, {}, kState), KeyframeReason::kMotion);

  AlignResult outside = good();
  outside.overlap = kOptions.overlap - 0.01;
  EXPECT_EQ(policy.due(outside, {}, kState), KeyframeReason::kOverlap);

  AlignResult unlike = good();
  unlike.inlier_ratio = kOptions.inliers - 0.01;
  EXPECT_EQ(policy.due(unlike, {}, kState), KeyframeReason::kInliers);
}

TEST(KeyframePolicy, ASharperFrameIsDueOnlyIfItFitsBadly) {
  const KeyframePolicy policy(kOptions);
  Frame sharp;
  sharp.sharpness = 2 * kState.keyframe_sharpness;
  AlignResult bad = good();
  bad.sigma = 2 * kState.usual_sigma;
  EXPECT_EQ(policy.due(bad, sharp, kState), KeyframeReason::kSharper);
  EXPECT_EQ(policy.due(good(), sharp, kState), std::nullopt);
  Frame blurred;
  blurred.sharpness = kState.keyframe_sharpness;
  EXPECT_EQ(policy.due(bad, blurred, kState), std::nullopt);
}

TEST(KeyframePolicy, HalfThePeriodIsEnoughWhereFramesFitWorseUnlessSomethingMoves) {
  const KeyframePolicy policy(kOptions);
  TrackingState half = kState;
  half.frames_since_keyframe = kOptions.period / 2;
  half.keyframe_sigma = 2;
  EXPECT_EQ(policy.due(good(), {}, half), KeyframeReason::kPeriod);
  half.doubtful_frames = 1;
  EXPECT_EQ(policy.due(good(), {}, half), std::nullopt);
  half.doubtful_frames = 0;
  half.keyframe_sigma = good().sigma;
  EXPECT_EQ(policy.due(good(), {}, half), std::nullopt);
}

TEST(KeyframePolicy, PeriodZeroIsNever) {
  TrackingState old = kState;
  old.frames_since_keyframe = 1000;
  EXPECT_EQ(KeyframePolicy({.period = 0}).due(good(), {}, old), std::nullopt);
}

}  // namespace
}  // namespace edvo
