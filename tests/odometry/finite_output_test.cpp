// SPDX-License-Identifier: MIT
// Whatever the images hold, no number that comes out is NaN or infinite.
#include "edvo/odometry/odometry.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace edvo {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

constexpr int kFrames = 16;

RgbdImage rendered(int i) {
  static const std::vector<RgbdImage> frames = [] {
    const auto sequence = test::make_sequence({.frames = kFrames}, test::kQvgaCamera);
    std::vector<RgbdImage> all;
    for (int n = 0; n < kFrames; ++n) all.push_back(synth::make_frame(sequence, n));
    return all;
  }();
  return frames.at(static_cast<std::size_t>(i));
}

cv::Mat_<cv::Vec3b> noise(const cv::Mat_<cv::Vec3b>& like, int seed) {
  cv::Mat_<cv::Vec3b> image(like.size());
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

// Every third pixel, and a block, of the depth.
void plant(RgbdImage& image, float value) {
  image.depth = image.depth.clone();
  for (int y = 0; y < image.depth.rows; ++y)
    for (int x = y % 3; x < image.depth.cols; x += 3) image.depth(y, x) = value;
  image.depth(cv::Rect(40, 40, 80, 60)).setTo(value);
}

struct Attack {
  const char* name;
  std::function<void(RgbdImage&, int)> on;
};

std::vector<Attack> attacks() {
  const auto depth_of = [](float value) {
    return [value](RgbdImage& image, int) {
      image.depth = cv::Mat_<float>(image.depth.size(), value);
    };
  };
  const auto planted = [](float value) {
    return [value](RgbdImage& image, int) { plant(image, value); };
  };
  const auto colour_of = [](int value) {
    return [value](RgbdImage& image, int) {
      image.bgr =
          cv::Mat_<cv::Vec3b>(image.bgr.size(), cv::Vec3b::all(static_cast<unsigned char>(value)));
    };
  };
  return {{"none", [](RgbdImage&, int) {}},
          {"black", colour_of(0)},
          {"white", colour_of(255)},
          {"noise", [](RgbdImage& image, int i) { image.bgr = noise(image.bgr, i); }},
          {"depth NaN", depth_of(kNaN)},
          {"depth infinite", depth_of(kInfinity)},
          {"depth zero", depth_of(0)},
          {"depth negative", depth_of(-1)},
          {"depth 1e-30 m", depth_of(1e-30F)},
          {"depth 1e30 m", depth_of(1e30F)},
          {"depth constant", depth_of(1)},
          {"some depth infinite", planted(kInfinity)},
          {"some depth negative", planted(-2)},
          {"some depth 1e-30 m", planted(1e-30F)},
          {"some depth 1e30 m", planted(1e30F)},
          {"one pixel of depth", [](RgbdImage& image, int) {
             image.depth = cv::Mat_<float>(image.depth.size(), kNaN);
             image.depth(100, 100) = 1;
           }}};
}

void expect_finite(const FrameResult& result, const std::string& what) {
  EXPECT_TRUE(is_finite(result.world_from_camera)) << what;
  EXPECT_TRUE(is_finite(result.keyframe_from_camera)) << what;
  EXPECT_TRUE(result.information.allFinite()) << what;
  for (const double value : {result.inlier_ratio, result.overlap, result.correlation, result.rms})
    EXPECT_TRUE(std::isfinite(value)) << what;
  for (const auto& level : result.levels) EXPECT_TRUE(std::isfinite(level.cost)) << what;
}

class FiniteOutput : public ::testing::TestWithParam<Method> {};

TEST_P(FiniteOutput, WhateverTheImagesHold) {
  for (const Attack& attack : attacks()) {
    Odometry odometry({test::kQvgaCamera, {}}, preset(GetParam()));
    for (int i = 0; i < kFrames; ++i) {
      RgbdImage image = rendered(i);
      const bool is_attacked = i % 8 >= 4;
      if (is_attacked) attack.on(image, i);
      expect_finite(odometry.process(image), attack.name);
    }
    odometry.finish();
    for (const Trajectory& trajectory : {odometry.trajectory(), odometry.keyframe_trajectory()})
      for (const StampedPose& pose : trajectory)
        EXPECT_TRUE(is_finite(pose.world_from_camera)) << attack.name;
  }
}

TEST_P(FiniteOutput, WhateverTheFirstImagesHold) {
  for (const Attack& attack : attacks()) {
    Odometry odometry({test::kQvgaCamera, {}}, preset(GetParam()));
    for (int i = 0; i < 8; ++i) {
      RgbdImage image = rendered(i);
      if (i < 4) attack.on(image, i);
      expect_finite(odometry.process(image), attack.name);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, FiniteOutput,
                         ::testing::Values(Method::kCannyCorner, Method::kOrigin),
                         [](const auto& method) {
                           return method.param == Method::kOrigin ? "Origin" : "CannyCorner";
                         });

}  // namespace
}  // namespace edvo
