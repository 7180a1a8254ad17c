// SPDX-License-Identifier: MIT
// What each kind of depth sensor gets wrong, on pictures given by their depth.
#include "edvo/synth/depth_models.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

namespace edvo::synth {
namespace {

constexpr double kFocal = 525;              // [px]
constexpr int kWidth = 320, kHeight = 240;  // [px]
constexpr int kEdge = 160;                  // first column of what lies behind [px]

// Grey 128 or, textured, a checker of 90 and 170; seen at right angles.
Render picture(const std::function<double(int x, int y)>& depth, bool textured = true) {
  Render image{.bgr = cv::Mat_<cv::Vec3f>(kHeight, kWidth),
               .depth = cv::Mat_<float>(kHeight, kWidth),
               .incidence = cv::Mat_<float>(kHeight, kWidth, 1.0F)};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      image.depth(y, x) = static_cast<float>(depth(x, y));
      const bool bright = (x / 3 + y / 3) % 2 == 0;
      image.bgr(y, x) = cv::Vec3f::all(!textured ? 128.0F : bright ? 170.0F : 90.0F);
    }
  return image;
}

Render wall(double distance, bool textured = true) {
  return picture([distance](int, int) { return distance; }, textured);
}

// 1 m on the left of kEdge, 2 m on its right.
Render step() {
  return picture([](int x, int) { return x < kEdge ? 1.0 : 2.0; });
}

cv::Mat_<float> measured(const Render& exact, SensorKind kind, std::uint64_t frame = 0) {
  SensorOptions options;
  options.kind = kind;
  return sense(exact, options, kFocal, 0, 7, frame, 1).depth;
}

std::vector<float> values_in(const cv::Mat_<float>& depth, int first_column, int end_column) {
  std::vector<float> values;
  for (int y = 0; y < depth.rows; ++y)
    for (int x = first_column; x < end_column; ++x)
      if (!std::isnan(depth(y, x))) values.push_back(depth(y, x));
  return values;
}

double median(std::vector<float> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double share(const std::vector<float>& values, const std::function<bool(float)>& holds) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), holds)) /
         static_cast<double>(values.size());
}

// 1.48 times the median deviation: the sigma of what is no outlier.
double robust_sigma(const cv::Mat_<float>& depth) {
  std::vector<float> values = values_in(depth, 0, depth.cols);
  const auto middle = static_cast<float>(median(values));
  for (float& value : values) value = std::abs(value - middle);
  return 1.4826 * median(values);
}

double missing_share(const cv::Mat_<float>& depth) {
  return 1 - static_cast<double>(values_in(depth, 0, depth.cols).size()) / (kWidth * kHeight);
}

// Distance of the two values of most weight next to each other.
double smallest_step(const cv::Mat_<float>& depth) {
  const std::vector<float> values = values_in(depth, 0, depth.cols);
  const std::set<float> distinct(values.begin(), values.end());
  double smallest = 1e9;
  for (auto it = std::next(distinct.begin()); it != distinct.end(); ++it)
    smallest = std::min<double>(smallest, *it - *std::prev(it));
  return smallest;
}

TEST(DepthModels, TheSameSeedGivesTheSameBitsOnAnyNumberOfThreads) {
  for (const auto& [kind, name] : EnumNames<SensorKind>::names) {
    SensorOptions options;
    options.kind = kind;
    const cv::Mat_<float> one = sense(step(), options, kFocal, 0, 7, 3, 1).depth;
    const cv::Mat_<float> many = sense(step(), options, kFocal, 0, 7, 3, 3).depth;
    EXPECT_TRUE(std::equal(one.begin(), one.end(), many.begin(), [](float a, float b) {
      return a == b || (std::isnan(a) && std::isnan(b));
    })) << name;
  }
}

TEST(DepthModels, FramesAndSeedsDifferUnlessClean) {
  for (const auto& [kind, name] : EnumNames<SensorKind>::names) {
    const cv::Mat_<float> a = measured(wall(2), kind, 1), b = measured(wall(2), kind, 2);
    EXPECT_EQ(cv::countNonZero(a != b) > 0, kind != SensorKind::kClean) << name;
  }
}

TEST(DepthModels, CleanIsExact) {
  const Render exact = step();
  EXPECT_EQ(cv::countNonZero(measured(exact, SensorKind::kClean) != exact.depth), 0);
}

TEST(DepthModels, StepsOfDisparitySensorsGrowWithTheSquareOfDepth) {
  for (const SensorKind kind : {SensorKind::kKinect1, SensorKind::kIcl, SensorKind::kStereo}) {
    const auto sloped = [](double z) {
      return picture([z](int x, int) { return z * (1 + 1e-3 * (x - kEdge) / kEdge); });
    };
    const double near = smallest_step(measured(sloped(1.5), kind));
    const double far = smallest_step(measured(sloped(3), kind));
    EXPECT_NEAR(far / near, 4, 0.8) << name_of(kind);
  }
}

TEST(DepthModels, IclStepAtFourMetresIsThatOfItsSequences) {
  EXPECT_NEAR(smallest_step(measured(wall(3.99), SensorKind::kIcl)), 0.0453, 0.002);
}

TEST(DepthModels, IclHasStraysBetweenTheTwoSidesAndBetweenZeroAndTheSurface) {
  const cv::Mat_<float> depth = measured(step(), SensorKind::kIcl);
  const std::vector<float> edge = values_in(depth, kEdge - 2, kEdge + 2);
  EXPECT_GT(share(edge, [](float z) { return z > 1.1F && z < 1.9F; }), 0.1);
  EXPECT_GT(share(edge, [](float z) { return z < 0.9F; }), 0.03);
  EXPECT_EQ(share(edge, [](float z) { return z > 2.1F; }), 0);
  const std::vector<float> flat = values_in(depth, 0, kEdge - 10);
  EXPECT_EQ(share(flat, [](float z) { return std::abs(z - 1) > 0.02F; }), 0);
  EXPECT_EQ(missing_share(measured(wall(2), SensorKind::kIcl)), 0);
}

TEST(DepthModels, FlyingPixelsOfTofLieBetweenTheTwoSides) {
  const cv::Mat_<float> depth = measured(step(), SensorKind::kTof);
  const std::vector<float> edge = values_in(depth, kEdge - 1, kEdge + 1);
  EXPECT_GT(share(edge, [](float z) { return z > 1.05F && z < 1.95F; }), 0.9);
  for (const float z : edge) {
    EXPECT_GT(z, 0.97F);
    EXPECT_LT(z, 2.03F);
  }
  const std::vector<float> beside = values_in(depth, kEdge - 6, kEdge - 2);
  EXPECT_EQ(share(beside, [](float z) { return z > 1.05F; }), 0);
}

TEST(DepthModels, TofNoiseGrowsWithDepthAndOnDarkSurfaces) {
  const double near = robust_sigma(measured(wall(1, false), SensorKind::kTof));
  const double far = robust_sigma(measured(wall(3, false), SensorKind::kTof));
  EXPECT_NEAR(far / near, 9, 2);
  Render dark = wall(1, false);
  dark.bgr = cv::Vec3f::all(32);
  EXPECT_NEAR(robust_sigma(measured(dark, SensorKind::kTof)) / near, 4, 1);
}

TEST(DepthModels, TofWigglesWithDepthByAFewMillimetres) {
  double smallest = 1, largest = -1;
  for (double z = 1.0; z < 1.5; z += 0.05) {
    const double off = median(values_in(measured(wall(z, false), SensorKind::kTof), 0, kWidth)) - z;
    smallest = std::min(smallest, off);
    largest = std::max(largest, off);
  }
  EXPECT_NEAR(largest - smallest, 0.008, 0.002);
}

TEST(DepthModels, CornersSeemFartherToTofAndWallsDoNot) {
  // Two walls at right angles that meet 2.5 m away; the bottom of the valley is the middle column.
  const Render corner =
      picture([](int x, int) { return 2.5 / (1 + std::abs(x - kEdge + 0.5) / kFocal); }, false);
  const cv::Mat_<float> depth = measured(corner, SensorKind::kTof);
  double deviation = 0;
  int count = 0;
  for (int y = 60; y < 180; ++y)
    for (int x = kEdge - 40; x < kEdge + 40; ++x, ++count)
      deviation += depth(y, x) - corner.depth(y, x);
  EXPECT_GT(deviation / count, 0.015);
  const double flat = median(values_in(measured(wall(2.5, false), SensorKind::kTof), 0, kWidth));
  EXPECT_LT(std::abs(flat - 2.5), 0.006);  // of wiggling
}

TEST(DepthModels, StereoWidensTheForegroundByTwoToFourPixels) {
  const cv::Mat_<float> depth = measured(step(), SensorKind::kStereo);
  const auto foreground = [](float z) { return z < 1.3F; };
  EXPECT_GT(share(values_in(depth, kEdge, kEdge + 2), foreground), 0.95);
  const double between = share(values_in(depth, kEdge + 2, kEdge + 4), foreground);
  EXPECT_GT(between, 0.3);
  EXPECT_LT(between, 0.7);
  EXPECT_LT(share(values_in(depth, kEdge + 5, kEdge + 12), foreground), 0.05);
}

TEST(DepthModels, StereoIsNotTooNearOnASlantedSurface) {
  const Render slanted = picture([](int x, int) { return 1 / (0.4 + 0.001 * x); });
  const cv::Mat_<float> depth = measured(slanted, SensorKind::kStereo);
  const cv::Mat_<float> ratio = depth / slanted.depth;
  EXPECT_NEAR(median(values_in(ratio, 20, kWidth)), 1, 0.002);
}

TEST(DepthModels, StereoHasAShadowOnTheLeftOfNearThings) {
  const Render image = picture([](int x, int) { return x < kEdge ? 2.0 : 1.0; });
  const cv::Mat_<float> depth = measured(image, SensorKind::kStereo);
  const int width = static_cast<int>(kFocal * 0.05 * (1 / 1.0 - 1 / 2.0));  // [px]
  EXPECT_TRUE(values_in(depth, kEdge - width + 1, kEdge - 4).empty());
  EXPECT_FALSE(values_in(depth, kEdge - width - 8, kEdge - width - 5).empty());
}

TEST(DepthModels, StereoIsWorseWithoutTexture) {
  const cv::Mat_<float> textured = measured(wall(2.5), SensorKind::kStereo);
  const cv::Mat_<float> plain = measured(wall(2.5, false), SensorKind::kStereo);
  EXPECT_GT(robust_sigma(plain), 1.5 * robust_sigma(textured));
  const auto blob = [](float z) { return std::abs(z - 2.5F) > 0.3F; };
  const double usual = share(values_in(textured, 0, kWidth), blob);
  EXPECT_GT(usual, 0);
  EXPECT_GT(share(values_in(plain, 0, kWidth), blob), 3 * usual);
  EXPECT_LT(missing_share(measured(wall(1, false), SensorKind::kStereo)), 0.001);
  EXPECT_GT(missing_share(measured(wall(4, false), SensorKind::kStereo)), 0.2);
}

TEST(DepthModels, StereoNoiseIsSharedByNeighbours) {
  const cv::Mat_<float> depth = measured(wall(2), SensorKind::kStereo);
  cv::Mat_<float> steps(depth.rows, depth.cols - 1);
  for (int y = 0; y < steps.rows; ++y)
    for (int x = 0; x < steps.cols; ++x) steps(y, x) = depth(y, x + 1) - depth(y, x);
  EXPECT_LT(robust_sigma(steps), robust_sigma(depth));  // of independent ones: 1.4 times
}

TEST(DepthModels, LidarSmearsEdgesOverSeveralPixelsAndHasNoHoles) {
  const cv::Mat_<float> depth = measured(step(), SensorKind::kLidarPhone);
  EXPECT_EQ(missing_share(depth), 0);
  for (int y = 0; y < kHeight; y += 20) {
    int between = 0;
    for (int x = kEdge - 20; x < kEdge + 20; ++x)
      between += depth(y, x) > 1.1F && depth(y, x) < 1.9F ? 1 : 0;
    EXPECT_GE(between, 3) << y;
    EXPECT_LE(between, 8) << y;
  }
}

TEST(DepthModels, LidarDepthIsEnlargedFrom256Columns) {
  // Enlarged 2.5 times by linear interpolation, second differences vanish between two samples.
  SensorOptions options;
  options.kind = SensorKind::kLidarPhone;
  Render exact{.bgr = cv::Mat_<cv::Vec3f>(480, 640, cv::Vec3f::all(128)),
               .depth = cv::Mat_<float>(480, 640, 2.0F),
               .incidence = cv::Mat_<float>(480, 640, 1.0F)};
  const cv::Mat_<float> depth = sense(exact, options, kFocal, 0, 7, 0, 1).depth;
  int kinks = 0;
  for (int x = 1; x < 639; ++x)
    kinks += std::abs(depth(200, x - 1) - 2 * depth(200, x) + depth(200, x + 1)) > 2e-5F ? 1 : 0;
  EXPECT_GT(kinks, 256);
  EXPECT_LE(kinks, 2 * 256);
}

TEST(DepthModels, LidarDeviatesByLessThanAPercentAndSmoothly) {
  const cv::Mat_<float> depth = measured(wall(2), SensorKind::kLidarPhone);
  const std::vector<float> all = values_in(depth, 0, kWidth);
  EXPECT_EQ(share(all, [](float z) { return std::abs(z / 2 - 1) > 0.014F; }), 0);
  EXPECT_GT(share(all, [](float z) { return std::abs(z / 2 - 1) > 0.002F; }), 0.2);
}

TEST(DepthModels, OnlyTheLidarIsLateByItself) {
  for (const auto& [kind, name] : EnumNames<SensorKind>::names) {
    SensorOptions options;
    options.kind = kind;
    EXPECT_EQ(depth_delay(options) > 0, kind == SensorKind::kLidarPhone) << name;
    options.depth_delay = 0.1;
    EXPECT_EQ(depth_delay(options) >= 0.1, kind != SensorKind::kClean) << name;
  }
}

}  // namespace
}  // namespace edvo::synth
