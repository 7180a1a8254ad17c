// SPDX-License-Identifier: MIT
#include "edvo/image/depth_registration.hpp"

#include "edvo/core/error.hpp"
#include "edvo/synth/rays.hpp"
#include "edvo/synth/render.hpp"
#include "edvo/synth/sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo {
namespace {

constexpr DistortedCamera kColour{
    .pinhole = {.fx = 525, .fy = 525, .cx = 319.5, .cy = 239.5, .width = 640, .height = 480}};
constexpr DistortedCamera kDepth{
    .pinhole = {.fx = 580, .fy = 580, .cx = 314, .cy = 246, .width = 640, .height = 480}};
// As of a structured light sensor: some centimetres beside the colour camera, not quite parallel.
const SE3 kColourFromDepth{.rotation = Eigen::Quaterniond(
                               Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.3, 1, 0.2).normalized())),
                           .translation = {0.052, 0.004, -0.003}};

cv::Mat_<float> rendered_depth(const synth::SyntheticSequence& sequence,
                               const SE3& world_from_camera, const DistortedCamera& camera) {
  return synth::render(sequence.scene, 0, world_from_camera, synth::make_rays(camera), 0).depth;
}

bool is_close(double a, double b) {
  constexpr double kTolerance = 0.01;  // of the depth
  return std::abs(a - b) < kTolerance * b;
}

// The depth camera sees the surface that the colour camera has at this pixel.
bool is_seen(const cv::Mat_<float>& truth, const cv::Mat_<float>& depth,
             const DistortedCamera& depth_camera, int x, int y) {
  const Eigen::Vector3d point =
      inverse(kColourFromDepth) * back_project(kColour.pinhole, x, y, truth(y, x));
  const Eigen::Vector2d pixel = project(depth_camera.pinhole, point);
  const int u = static_cast<int>(std::lround(pixel.x()));
  const int v = static_cast<int>(std::lround(pixel.y()));
  return u >= 0 && v >= 0 && u < depth.cols && v < depth.rows && is_close(depth(v, u), point.z());
}

// Of the pixels with a surface: depth as rendered where the depth camera sees it, else none or,
// where the depth camera sees another surface within half a pixel, that surface.
double share_of_right_pixels(synth::SceneName scene, const DistortedCamera& depth_camera) {
  const auto sequence = synth::make_sequence({.scene = scene, .frames = 1});
  const SE3 world_from_colour = synth::pose_of(sequence, 0).world_from_camera;
  const cv::Mat_<float> truth = rendered_depth(sequence, world_from_colour, kColour);
  const cv::Mat_<float> depth =
      rendered_depth(sequence, world_from_colour * kColourFromDepth, depth_camera);
  const cv::Mat_<float> registered =
      register_depth(make_depth_registration(depth_camera, kColour, kColourFromDepth), depth);
  int right = 0, all = 0;
  for (int y = 0; y < truth.rows; ++y)
    for (int x = 0; x < truth.cols; ++x) {
      if (std::isnan(truth(y, x))) continue;
      ++all;
      right += std::isnan(registered(y, x)) ? !is_seen(truth, depth, depth_camera, x, y)
                                            : is_close(registered(y, x), truth(y, x));
    }
  return static_cast<double>(right) / all;
}

TEST(DepthRegistration, NinetyNinePercentOfPixelsAreAsTheColourCameraWouldMeasure) {
  for (const auto& [scene, name] : EnumNames<synth::SceneName>::names) {
    const double share = share_of_right_pixels(scene, kDepth);
    RecordProperty(std::string(name), std::to_string(share));
    EXPECT_GE(share, 0.99) << name;
  }
}

TEST(DepthRegistration, FillsAFinerColourImageWithoutHoles) {
  DistortedCamera coarse = kDepth;
  coarse.pinhole = {.fx = 230, .fy = 230, .cx = 127.5, .cy = 95.5, .width = 256, .height = 192};
  for (const auto& [scene, name] : EnumNames<synth::SceneName>::names) {
    const double share = share_of_right_pixels(scene, coarse);
    RecordProperty(std::string(name), std::to_string(share));
    EXPECT_GE(share, 0.97) << name;
  }
}

TEST(DepthRegistration, TheSameCameraChangesNothing) {
  const auto sequence = synth::make_sequence({.scene = synth::SceneName::kOffice, .frames = 1});
  const cv::Mat_<float> depth =
      rendered_depth(sequence, synth::pose_of(sequence, 0).world_from_camera, kColour);
  const cv::Mat_<float> registered =
      register_depth(make_depth_registration(kColour, kColour, {}), depth);
  double largest = 0;
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x)
      largest = std::max(largest, std::abs(static_cast<double>(depth(y, x)) - registered(y, x)));
  EXPECT_LT(largest, 1e-4);
}

TEST(DepthRegistration, TheNearerSurfaceHidesTheOther) {
  cv::Mat_<float> depth(480, 640, 3.0F);
  depth(cv::Rect(300, 200, 60, 60)) = 1.0F;
  const SE3 colour_from_depth{.translation = {0.05, 0, 0}};
  const cv::Mat_<float> registered =
      register_depth(make_depth_registration(kColour, kColour, colour_from_depth), depth);
  // 0.05 m at 1 m move by 26.25 px, at 3 m by 8.75 px.
  for (int x = 328; x < 385; ++x) ASSERT_NEAR(registered(230, x), 1.0F, 1e-5) << x;
  // Between them the colour camera sees what the depth camera does not.
  for (int x = 310; x < 326; ++x) ASSERT_TRUE(std::isnan(registered(230, x))) << x;
}

TEST(DepthRegistration, FollowsTheDistortionOfBothLenses) {
  DistortedCamera colour = kColour, depth = kDepth;
  colour.distortion = {0.12, -0.25, 0.001, -0.002, 0.05};
  depth.distortion = {-0.08, 0.05, 0, 0, 0};
  const cv::Mat_<float> wall(480, 640, 2.0F);
  const cv::Mat_<float> registered =
      register_depth(make_depth_registration(depth, colour, {}), wall);
  int missing = 0;
  for (int y = 60; y < 420; ++y)
    for (int x = 60; x < 580; ++x) {
      missing += std::isnan(registered(y, x));
      if (!std::isnan(registered(y, x))) {
        ASSERT_NEAR(registered(y, x), 2.0F, 1e-4);
      }
    }
  EXPECT_EQ(missing, 0);
}

// Where a nearer patch comes to lie, by its mean pixel.
TEST(DepthRegistration, FollowsRationalAndEquidistantLenses) {
  DistortedCamera rational = kColour, equidistant = kColour;
  rational.distortion = {0.5, -2.6, 0.0005, -0.0002, 1.5, 0.2, -1.2, 0.7};
  equidistant.distortion = {-0.02, 0.01, -0.003, 0.0005};
  equidistant.lens = LensModel::kEquidistant;
  cv::Mat_<float> depth(480, 640, 3.0F);
  depth(cv::Rect(440, 120, 21, 21)) = 1.0F;
  for (const DistortedCamera& colour : {rational, equidistant}) {
    const cv::Mat_<float> registered =
        register_depth(make_depth_registration(kDepth, colour, {}), depth);
    cv::Point2d sum;
    int count = 0;
    for (int y = 0; y < registered.rows; ++y)
      for (int x = 0; x < registered.cols; ++x)
        if (std::abs(registered(y, x) - 1.0F) < 0.01F) {
          sum += cv::Point2d(x, y);
          ++count;
        }
    ASSERT_GT(count, 100) << distortion_model(colour);
    const Camera& k = colour.pinhole;
    const Eigen::Vector2d at =
        distort(colour, undistort(kDepth, {(450 - kDepth.pinhole.cx) / kDepth.pinhole.fx,
                                           (130 - kDepth.pinhole.cy) / kDepth.pinhole.fy}));
    EXPECT_NEAR(sum.x / count, k.fx * at.x() + k.cx, 0.5) << distortion_model(colour);
    EXPECT_NEAR(sum.y / count, k.fy * at.y() + k.cy, 0.5) << distortion_model(colour);
  }
}

TEST(DepthRegistration, RefusesDepthOfAnotherSize) {
  EXPECT_THROW((void)register_depth(make_depth_registration(kDepth, kColour, {}),
                                    cv::Mat_<float>(48, 64, 1.0F)),
               Error);
}

}  // namespace
}  // namespace edvo
