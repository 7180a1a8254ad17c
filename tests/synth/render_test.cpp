// SPDX-License-Identifier: MIT
#include "edvo/synth/render.hpp"

#include "edvo/core/camera.hpp"
#include "edvo/image/depth.hpp"
#include "edvo/synth/path.hpp"
#include "edvo/synth/rays.hpp"
#include "edvo/synth/sequence.hpp"
#include "support/same_bits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace edvo::synth {
namespace {

using test::same_bits;

constexpr Camera kCamera{
    .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5, .width = 160, .height = 120};
const DistortedCamera kFr1{
    .pinhole = {.fx = 129.3, .fy = 129.1, .cx = 79.3, .cy = 63.5, .width = 160, .height = 120},
    .distortion = {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}};

// One solid of a plain grey in front of a camera at the origin that looks along the world's z.
Scene single(const Solid& solid) {
  Scene scene;
  scene.textures = {make_texture(Pattern::kPlaster, 1)};
  scene.materials = {
      {.texture = 0, .dark = {80, 80, 80}, .bright = {200, 200, 200}, .tile = {1, 1}}};
  scene.solids = {solid};
  scene.light = {0, -1, 0};
  return scene;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Eigen::Vector3d point_at(const Render& image, const cv::Mat_<cv::Vec2f>& rays, int x, int y) {
  const double z = image.depth(y, x);
  return {rays(y, x)[0] * z, rays(y, x)[1] * z, z};
}

TEST(Render, DepthOfATurnedBoxLiesOnItsFaces) {
  const SE3 world_from_box{.rotation = Eigen::Quaterniond(
                               Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 0.5).normalized())),
                           .translation = {0.1, -0.05, 2.0}};
  const Scene scene = single(
      {.shape = Shape::kBox, .world_from_solid = world_from_box, .half = {0.4F, 0.3F, 0.5F}});
  const cv::Mat_<cv::Vec2f> rays = make_rays({kCamera});
  const Render image = render(scene, 0, SE3{}, rays, 1);
  int seen = 0;
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x) {
      if (std::isnan(image.depth(y, x))) continue;
      ++seen;
      const Eigen::Vector3d local = inverse(world_from_box) * point_at(image, rays, x, y);
      const double outside = (local.cwiseAbs() - scene.solids[0].half.cast<double>()).maxCoeff();
      EXPECT_NEAR(outside, 0, 1e-5);
    }
  EXPECT_GT(seen, 1000);
}

TEST(Render, DepthOfABallLiesOnIt) {
  const Eigen::Vector3d centre{-0.1, 0.2, 1.5};
  const Scene scene = single({.shape = Shape::kSphere,
                              .world_from_solid = {.translation = centre},
                              .half = Eigen::Vector3f::Constant(0.5F)});
  const cv::Mat_<cv::Vec2f> rays = make_rays({kCamera});
  const Render image = render(scene, 0, SE3{}, rays, 1);
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x) {
      const Eigen::Vector3d ray{rays(y, x)[0], rays(y, x)[1], 1};
      const double miss = ray.normalized().cross(centre).norm();
      if (std::isnan(image.depth(y, x))) {
        EXPECT_GT(miss, 0.499);
      } else {
        EXPECT_NEAR((point_at(image, rays, x, y) - centre).norm(), 0.5, 1e-5);
      }
    }
}

TEST(Render, DepthOfAColumnLiesOnItsSideOrCap) {
  const SE3 world_from_column{
      .rotation = Eigen::Quaterniond(Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitX())),
      .translation = {0, 0, 1.2}};
  const Scene scene = single({.shape = Shape::kCylinder,
                              .world_from_solid = world_from_column,
                              .half = {0.2F, 0.2F, 0.3F}});
  const cv::Mat_<cv::Vec2f> rays = make_rays({kCamera});
  const Render image = render(scene, 0, SE3{}, rays, 1);
  int on_side = 0, on_cap = 0;
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x) {
      if (std::isnan(image.depth(y, x))) continue;
      const Eigen::Vector3d local = inverse(world_from_column) * point_at(image, rays, x, y);
      const double side = local.head<2>().norm() - 0.2, cap = std::abs(local.z()) - 0.3;
      EXPECT_NEAR(std::max(side, cap), 0, 1e-5);
      (side > cap ? on_side : on_cap)++;
    }
  EXPECT_GT(on_side, 200);
  EXPECT_GT(on_cap, 200);
}

TEST(Render, DepthIsNeverAMixOfForegroundAndBackground) {
  Scene scene = single({.shape = Shape::kRoom, .half = {2, 2, 3}});
  scene.solids.push_back({.shape = Shape::kBox,
                          .world_from_solid = {.translation = {0, 0, 1.1}},
                          .half = {0.3F, 0.2F, 0.1F}});
  const Render image = render(scene, 0, SE3{}, make_rays({kCamera}), 1);
  for (int y = 20; y < 100; ++y)
    for (int x = 20; x < 140; ++x) {
      const float z = image.depth(y, x);
      EXPECT_TRUE(std::abs(z - 1.0F) < 1e-5F || z > 1.2F) << x << " " << y << " " << z;
    }
}

TEST(Render, RaysOfADistortedCameraUndoItsDistortion) {
  const cv::Mat_<cv::Vec2f> rays = make_rays(kFr1);
  const auto& k = kFr1.distortion;
  for (int v = 0; v < 120; v += 17)
    for (int u = 0; u < 160; u += 13) {
      const double x = rays(v, u)[0], y = rays(v, u)[1], r2 = x * x + y * y;
      const double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
      const double xd = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x);
      const double yd = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y;
      EXPECT_NEAR(kFr1.pinhole.fx * xd + kFr1.pinhole.cx, u, 1e-3);
      EXPECT_NEAR(kFr1.pinhole.fy * yd + kFr1.pinhole.cy, v, 1e-3);
    }
}

TEST(Render, UndistortedPictureOfADistortedCameraIsThatOfThePinhole) {
  const Scene scene = make_scene(SceneName::kDesk, 0);
  const SE3 pose = look_at(scene.stage.eye, scene.stage.target);
  const Render distorted = render(scene, 0, pose, make_rays(kFr1), 0);
  const Render ideal = render(scene, 0, pose, make_rays({kFr1.pinhole}), 0);
  const Undistortion undistortion = make_undistortion(kFr1);
  cv::Mat_<cv::Vec3b> rounded;
  distorted.bgr.convertTo(rounded, CV_8U);
  const cv::Mat_<cv::Vec3b> colour = undistort_colour(undistortion, rounded);
  const cv::Mat_<float> depth = Depth(undistortion, distorted.depth).undistorted();
  std::vector<double> grey_errors, depth_errors;
  for (int y = 0; y < kFr1.pinhole.height; ++y)
    for (int x = 0; x < kFr1.pinhole.width; ++x) {
      if (undistortion.valid(y, x) == 0 || std::isnan(depth(y, x))) continue;
      grey_errors.push_back(std::abs(colour(y, x)[1] - ideal.bgr(y, x)[1]));
      depth_errors.push_back(std::abs(depth(y, x) - ideal.depth(y, x)));
    }
  EXPECT_GT(grey_errors.size() * 10, 9 * ideal.depth.total());
  EXPECT_LT(median(grey_errors), 1.0);
  EXPECT_LT(median(depth_errors), 0.005);
}

TEST(Render, GivesTheSameBitsForAnyNumberOfThreads) {
  const Scene scene = make_scene(SceneName::kOffice, 3);
  const SE3 pose = look_at(scene.stage.eye, scene.stage.target);
  const cv::Mat_<cv::Vec2f> rays = make_rays(kFr1);
  const Render one = render(scene, 0, pose, rays, 1);
  for (const int threads : {2, 3, 7}) {
    const Render many = render(scene, 0, pose, rays, threads);
    EXPECT_TRUE(same_bits(one.bgr, many.bgr));
    EXPECT_TRUE(same_bits(one.depth, many.depth));
    EXPECT_TRUE(same_bits(one.incidence, many.incidence));
  }
}

// Median over the pixels of one view of the difference in green [grey levels] to where a second
// view shows the same surface, if to_from is the motion between them.
double median_warp_error(const Render& from, const Render& to, const SE3& to_from) {
  std::vector<double> errors;
  for (int y = 4; y < 476; y += 4)
    for (int x = 4; x < 636; x += 4) {
      const Eigen::Vector3d point =
          to_from * back_project(kDefaultCamera.pinhole, x, y, from.depth(y, x));
      const Eigen::Vector2d pixel = project(kDefaultCamera.pinhole, point);
      const auto u = static_cast<int>(pixel.x()), v = static_cast<int>(pixel.y());
      if (u < 1 || v < 1 || u > 637 || v > 477) continue;
      if (std::abs(to.depth(v, u) - point.z()) > 0.02 * point.z()) continue;  // hidden
      const double a = pixel.x() - u, b = pixel.y() - v;
      const auto green = [&](int column, int row) { return to.bgr(row, column)[1]; };
      const double seen = (1 - b) * ((1 - a) * green(u, v) + a * green(u + 1, v)) +
                          b * ((1 - a) * green(u, v + 1) + a * green(u + 1, v + 1));
      errors.push_back(std::abs(seen - from.bgr(y, x)[1]));
    }
  EXPECT_GT(errors.size(), 5000U);
  return median(errors);
}

TEST(Render, TwoViewsWarpOntoEachOtherBestByTheTrueMotion) {
  Vector6d xi, slip;
  xi << 0.04, -0.02, 0.05, 0.01, -0.02, 0.015;
  slip << 0.003, -0.003, 0, 0.002, 0.002, 0;  // about two pixels
  const cv::Mat_<cv::Vec2f> rays = make_rays(kDefaultCamera);
  for (const SceneName name : {SceneName::kDesk, SceneName::kLivingRoom, SceneName::kBoxes}) {
    const Scene scene = make_scene(name, 0);
    const SE3 world_from_a = look_at(scene.stage.eye, scene.stage.target);
    const SE3 world_from_b = world_from_a * exp(xi);
    const Render a = render(scene, 0, world_from_a, rays, 0);
    const Render b = render(scene, 0, world_from_b, rays, 0);
    const double error = median_warp_error(a, b, exp(-xi));
    EXPECT_LT(error, 0.3) << name_of(name);
    EXPECT_GT(median_warp_error(a, b, exp(-xi) * exp(slip)), 2 * error) << name_of(name);
  }
}

TEST(Scene, EveryStageIsClearOfFurniture) {
  for (const auto& [name, text] : EnumNames<SceneName>::names)
    for (const std::uint64_t seed : {0, 1, 2, 3}) {
      const Scene scene = make_scene(name, seed);
      EXPECT_GT(clearance(scene, scene.stage.eye), 0.3) << text;
      EXPECT_EQ(scene.solids.front().shape, Shape::kRoom) << text;
    }
}

TEST(Scene, ClearanceIsTheDistanceToTheNearestSurface) {
  Scene scene = single({.shape = Shape::kRoom, .half = {2, 2, 2}});
  EXPECT_NEAR(clearance(scene, {0.5, 0, 0}), 1.5, 1e-6);
  EXPECT_NEAR(clearance(scene, {2.5, 0, 0}), -0.5, 1e-6);
  scene.solids.push_back({.shape = Shape::kBox, .half = {0.3F, 0.3F, 0.3F}});
  EXPECT_NEAR(clearance(scene, {0.5, 0, 0}), 0.2, 1e-6);
  EXPECT_NEAR(clearance(scene, {0.6, 0.7, 0}), 0.5, 1e-6);
  EXPECT_NEAR(clearance(scene, {0.2, 0, 0}), -0.1, 1e-6);
}

TEST(Scene, SameSeedGivesTheSameSceneAndAnotherSeedAnother) {
  const cv::Mat_<cv::Vec2f> rays = make_rays({kCamera});
  const auto picture = [&](std::uint64_t seed) {
    const Scene scene = make_scene(SceneName::kDesk, seed);
    return render(scene, 0, look_at(scene.stage.eye, scene.stage.target), rays, 0).bgr;
  };
  EXPECT_TRUE(same_bits(picture(5), picture(5)));
  EXPECT_FALSE(same_bits(picture(5), picture(6)));
}

}  // namespace
}  // namespace edvo::synth
