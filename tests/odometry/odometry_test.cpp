// SPDX-License-Identifier: MIT
#include "edvo/odometry/odometry.hpp"

#include "edvo/core/error.hpp"
#include "edvo/source/prefetch.hpp"
#include "support/made_source.hpp"
#include "support/matchers.hpp"
#include "support/rendered_sequence.hpp"
#include "support/synthetic_plane.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::NearPose;
using test::SyntheticPlane;

constexpr SyntheticPlane kPlane{.distance = 2.0};
constexpr double kRate = 30;  // [Hz]
// The wall is seen at an angle: constant depth is none.
const SE3 kOblique = exp((Vector6d() << 0, 0, 0, 0.05, 0.08, 0).finished());

Stamp stamp_of(int i) {
  return stamp_from_seconds(i / kRate, 6);
}

SE3 sideways(int i) {
  return {.translation = {0.008 * i, 0.004 * i, 0}};
}

RgbdImage view(int i, const SE3& pose) {
  return test::render_plane(kPlane, kVgaCamera, kOblique * pose, stamp_of(i));
}

RgbdImage nothing(int i) {
  return {.stamp = stamp_of(i),
          .bgr = cv::Mat_<cv::Vec3b>(480, 640, cv::Vec3b::all(0)),
          .depth = cv::Mat_<float>(480, 640, std::numeric_limits<float>::quiet_NaN())};
}

TEST(Odometry, FollowsACameraAlongAPlane) {
  Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
  for (int i = 0; i < 20; ++i) {
    const FrameResult report = odometry.process(view(i, sideways(i)));
    EXPECT_EQ(report.status, i == 0 ? FrameStatus::kFirst : FrameStatus::kTracked);
    EXPECT_THAT(report.world_from_camera, NearPose(sideways(i), 4e-3)) << i;
  }
  EXPECT_EQ(odometry.trajectory().size(), 20U);
  EXPECT_GE(odometry.keyframe_trajectory().size(), 2U);
}

// As phones and short-range cameras are held: the same images of a wall ten times as small.
TEST(Odometry, FollowsACameraAHandsBreadthFromAPlane) {
  constexpr double kScale = 0.1;
  Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
  for (int i = 0; i < 20; ++i) {
    RgbdImage image = view(i, sideways(i));
    image.depth *= kScale;
    const FrameResult report = odometry.process(image);
    EXPECT_EQ(report.status, i == 0 ? FrameStatus::kFirst : FrameStatus::kTracked);
    const SE3 truth = {.translation = kScale * sideways(i).translation};
    EXPECT_THAT(report.world_from_camera, NearPose(truth, 4e-4)) << i;
  }
}

// One view of a room, at different times.
RgbdImage still(int i, bool blurred) {
  static const RgbdImage sharp =
      synth::make_frame(test::make_sequence({.frames = 1, .sensor = {}}, test::kQvgaCamera), 0);
  RgbdImage image = sharp;
  image.stamp = stamp_of(i);
  if (!blurred) return image;
  image.bgr = sharp.bgr.clone();
  cv::GaussianBlur(sharp.bgr, image.bgr, {}, 6, 1);
  return image;
}

TEST(Odometry, ABlurredKeyframeGivesWayToTheFirstSharpFrame) {
  Odometry odometry({test::kQvgaCamera, {}}, preset(Method::kCannyCorner));
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(odometry.process(still(i, true)).keyframe_reason.has_value(), i == 0) << i;
  EXPECT_EQ(odometry.process(still(6, false)).keyframe_reason, KeyframeReason::kSharper);
  EXPECT_EQ(odometry.process(still(7, false)).keyframe_reason, std::nullopt);
}

TEST(Odometry, ASharpKeyframeStaysWhileFramesAreBlurred) {
  Odometry odometry({test::kQvgaCamera, {}}, preset(Method::kCannyCorner));
  for (int i = 0; i < 3; ++i) (void)odometry.process(still(i, false));
  for (int i = 3; i < 8; ++i)
    EXPECT_EQ(odometry.process(still(i, true)).keyframe_reason, std::nullopt) << i;
}

TEST(Odometry, KeyframesComeByPeriod) {
  Config config = preset(Method::kCannyCorner);
  config.keyframes = {.period = 4, .translation = 100, .rotation = 100, .overlap = 0, .inliers = 0};
  Odometry odometry({kVgaCamera, {}}, config);
  for (int i = 0; i < 13; ++i) {
    const FrameResult report = odometry.process(view(i, {}));
    const bool expected = i % 4 == 0;
    EXPECT_EQ(report.keyframe_reason.has_value(), expected) << i;
    if (i > 0 && expected) {
      EXPECT_EQ(report.keyframe_reason, KeyframeReason::kPeriod);
    }
  }
}

TEST(Odometry, KeyframesComeByMotion) {
  Config config = preset(Method::kCannyCorner);
  config.keyframes = {
      .period = 0, .translation = 0.03, .rotation = 100, .overlap = 0, .inliers = 0};
  Odometry odometry({kVgaCamera, {}}, config);
  int by_motion = 0;
  for (int i = 0; i < 10; ++i)
    by_motion += odometry.process(view(i, sideways(i))).keyframe_reason == KeyframeReason::kMotion;
  EXPECT_GE(by_motion, 2);
}

TEST(Odometry, StandingStillStaysWhereItIs) {
  Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
  for (int i = 0; i < 45; ++i)
    EXPECT_THAT(odometry.process(view(i, {})).world_from_camera, NearPose(SE3{}, 1e-3));
}

TEST(Odometry, SaysLostAndGoesOnWhenItCan) {
  Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
  for (int i = 0; i < 5; ++i) (void)odometry.process(view(i, sideways(i)));
  for (int i = 5; i < 8; ++i) {
    const FrameResult report = odometry.process(nothing(i));
    EXPECT_EQ(report.status, FrameStatus::kLost);
    EXPECT_TRUE(is_finite(report.world_from_camera));
  }
  const FrameResult back = odometry.process(view(8, sideways(5)));
  EXPECT_EQ(back.status, FrameStatus::kTracked);
  EXPECT_THAT(back.world_from_camera, NearPose(sideways(5), 4e-3));
  EXPECT_EQ(odometry.trajectory().size(), 6U);  // lost frames are left out
}

TEST(Odometry, BeginsASegmentAfterTheLostFramesThatAreAllowed) {
  Config config = preset(Method::kCannyCorner);
  config.keyframes.max_lost_frames = 2;
  config.selection.min_gradient = 0;  // the plane is smooth
  Odometry odometry({kVgaCamera, {}}, config);
  for (int i = 0; i < 3; ++i) (void)odometry.process(view(i, {}));
  for (int i = 3; i < 5; ++i)
    EXPECT_EQ(odometry.process(nothing(i)).status, FrameStatus::kLost) << i;
  const SE3 elsewhere{.translation = {1.5, -0.8, 0}};
  const FrameResult restarted = odometry.process(view(5, elsewhere));
  EXPECT_EQ(restarted.status, FrameStatus::kRestarted);
  EXPECT_EQ(restarted.segment, 1);
  const FrameResult next = odometry.process(view(6, elsewhere));
  EXPECT_EQ(next.status, FrameStatus::kTracked);
  EXPECT_EQ(next.segment, 1);
}

TEST(Odometry, WaitsForTheFirstImageThatCanBeUsed) {
  Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
  EXPECT_EQ(odometry.process(nothing(0)).status, FrameStatus::kLost);
  EXPECT_EQ(odometry.process(view(1, {})).status, FrameStatus::kFirst);
}

TEST(Odometry, RefusesAnImageOfAnotherSizeOrFromThePast) {
  Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
  (void)odometry.process(view(5, {}));
  EXPECT_THROW((void)odometry.process(view(5, {})), Error);
  EXPECT_THROW((void)odometry.process(view(4, {})), Error);
  RgbdImage small = view(6, {});
  small.depth = cv::Mat_<float>(240, 320, 1.F);
  EXPECT_THROW((void)odometry.process(small), Error);
  EXPECT_EQ(odometry.process(view(6, {})).status, FrameStatus::kTracked);  // nothing was changed
}

TEST(Odometry, GivesTheSameBitsTwice) {
  const auto poses = [] {
    Odometry odometry({kVgaCamera, {}}, preset(Method::kCannyCorner));
    for (int i = 0; i < 12; ++i) (void)odometry.process(view(i, sideways(i)));
    return odometry.trajectory();
  };
  const Trajectory a = poses(), b = poses();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].world_from_camera.translation, b[i].world_from_camera.translation);
    EXPECT_EQ(a[i].world_from_camera.rotation.coeffs(), b[i].world_from_camera.rotation.coeffs());
  }
}

TEST(Odometry, ImagesPreparedByAnotherThreadGiveTheSameBits) {
  constexpr int kImages = 12;
  Odometry direct({kVgaCamera, {}}, preset(Method::kCannyCorner));
  Odometry stepwise({kVgaCamera, {}}, preset(Method::kCannyCorner));
  const auto image = [](std::int64_t i) {
    return view(static_cast<int>(i), sideways(static_cast<int>(i)));
  };
  test::MadeSource source(kImages, image);
  Prefetch prepared([&](const PendingFrame& frame) { return stepwise.prepare(frame.load()); },
                    source, {.threads = 3});
  while (const auto next = prepared.next()) {
    const SE3 expected = direct.process(image(next->index)).world_from_camera;
    const SE3 pose = stepwise.process(std::get<PreparedImage>(next->content)).world_from_camera;
    EXPECT_EQ(pose.translation, expected.translation) << next->index;
    EXPECT_EQ(pose.rotation.coeffs(), expected.rotation.coeffs()) << next->index;
  }
  EXPECT_EQ(stepwise.trajectory().size(), std::size_t{kImages});
}

TEST(Odometry, DenseMethodFollowsToo) {
  Odometry odometry({kVgaCamera, {}}, preset(Method::kOrigin));
  for (int i = 0; i < 5; ++i)
    EXPECT_THAT(odometry.process(view(i, sideways(i))).world_from_camera,
                NearPose(sideways(i), 4e-3));
}

}  // namespace
}  // namespace edvo
