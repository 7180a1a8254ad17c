// SPDX-License-Identifier: MIT
#include "edvo/synth/sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>

namespace edvo::synth {
namespace {

constexpr double kFocal = 525;  // [px]
constexpr int kSide = 200;      // [px]

// A picture given by its depth; grey 100, seen at right angles.
Render picture(const std::function<double(int x, int y)>& depth) {
  Render image{.bgr = cv::Mat_<cv::Vec3f>(kSide, kSide, cv::Vec3f::all(100)),
               .depth = cv::Mat_<float>(kSide, kSide),
               .incidence = cv::Mat_<float>(kSide, kSide, 1.0F)};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) image.depth(y, x) = static_cast<float>(depth(x, y));
  return image;
}

Render wall(double distance) {
  return picture([distance](int, int) { return distance; });
}

RgbdImage seen(const Render& exact, const SensorOptions& options, double seconds = 0,
               std::uint64_t frame = 0) {
  return sense(exact, options, kFocal, seconds, 7, frame, 1);
}

struct Statistics {
  double mean = 0, sigma = 0, missing = 0;  // missing: share [0..1]
};

template <typename Function>  // Function(x, y) -> value, NaN = missing
Statistics statistics(const Function& value) {
  double sum = 0, squares = 0, count = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double v = value(x, y);
      if (std::isnan(v)) continue;
      sum += v;
      squares += v * v;
      ++count;
    }
  const double mean = sum / count;
  return {.mean = mean,
          .sigma = std::sqrt(squares / count - mean * mean),
          .missing = 1 - count / (kSide * kSide)};
}

Statistics depth_statistics(const RgbdImage& image) {
  return statistics([&](int x, int y) { return image.depth(y, x); });
}

Statistics colour_statistics(const RgbdImage& image) {
  return statistics([&](int x, int y) { return image.bgr(y, x)[1]; });
}

TEST(Sensor, DepthNoiseGrowsWithTheSquareOfDepth) {
  const SensorOptions options;
  for (const double z : {0.8, 1.5, 2.5, 4.0}) {
    const Statistics depth = depth_statistics(seen(wall(z), options));
    EXPECT_NEAR(depth.mean, z, 2e-3 * z * z) << z;
    EXPECT_NEAR(depth.sigma, 1.4e-3 * z * z, 0.15 * 1.4e-3 * z * z) << z;
    EXPECT_EQ(depth.missing, 0) << z;
  }
}

TEST(Sensor, DepthComesInDisparityStepsOfAnEighthPixel) {
  const RgbdImage image = seen(wall(2.0), {});
  std::set<float> values;
  for (const float z : image.depth) {
    const double steps = 580 * 0.075 / z / 0.125;
    EXPECT_NEAR(steps, std::round(steps), 1e-3);
    values.insert(z);
  }
  EXPECT_GT(values.size(), 2U);
  EXPECT_LT(values.size(), 12U);
}

TEST(Sensor, CorrelatedDepthNoiseKeepsItsStrength) {
  SensorOptions options;
  options.depth_correlation = 2;
  options.disparity_step = 0;
  const RgbdImage image = seen(wall(2.0), options);
  EXPECT_NEAR(depth_statistics(image).sigma, 1.4e-3 * 4, 0.1 * 1.4e-3 * 4);
  const Statistics step = statistics([&](int x, int y) {
    return x == 0 ? std::nan("") : image.depth(y, x) - image.depth(y, x - 1);
  });
  EXPECT_LT(step.sigma, 0.8 * 1.4e-3 * 4);  // of independent neighbours: 1.4 times the noise
}

TEST(Sensor, SeesNothingTooNearOrTooFar) {
  EXPECT_EQ(depth_statistics(seen(wall(0.3), {})).missing, 1);
  EXPECT_EQ(depth_statistics(seen(wall(5.5), {})).missing, 1);
}

TEST(Sensor, SeesNothingAtGrazingAngles) {
  Render image = wall(2);
  image.incidence = 0.0872F;  // cos 85 deg
  EXPECT_EQ(depth_statistics(seen(image, {})).missing, 1);
  image.incidence = 0.2588F;  // cos 75 deg
  EXPECT_EQ(depth_statistics(seen(image, {})).missing, 0);
}

TEST(Sensor, NearThingsCastAShadowOnTheirLeftOnly) {
  SensorOptions options;
  options.depth_edge_jitter = 0;
  const Render image = picture([](int x, int) { return x >= 90 && x < 130 ? 1.0 : 2.0; });
  const RgbdImage measured = seen(image, options);
  const int width = static_cast<int>(kFocal * 0.075 * (1 / 1.0 - 1 / 2.0));  // [px]
  for (int y = 0; y < kSide; y += 10) {
    for (int x = 0; x < kSide; ++x) {
      const bool shadow = x >= 90 - width + 1 && x < 90;
      if (x == 90 - width || x == 90 - width - 1) continue;  // rounding
      EXPECT_EQ(std::isnan(measured.depth(y, x)), shadow) << x;
    }
  }
}

TEST(Sensor, SlantedSurfacesCastNoShadowOnThemselves) {
  const Render image = picture([](int x, int) { return 1.0 + 0.004 * x; });
  EXPECT_EQ(depth_statistics(seen(image, {})).missing, 0);
}

TEST(Sensor, DepthEdgesFrayButStayOneSideOrTheOther) {
  const Render image = picture([](int x, int) { return x >= 100 ? 2.0 : 1.0; });
  const RgbdImage measured = seen(image, {});
  int wrong = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const float z = measured.depth(y, x);
      if (std::isnan(z)) continue;
      EXPECT_TRUE(std::abs(z - 1) < 0.02F || std::abs(z - 2) < 0.05F);
      if ((x >= 100) != (z > 1.5F)) {
        ++wrong;
        EXPECT_LE(std::abs(x - 100), 3);
      }
    }
  EXPECT_GT(wrong, 10);
}

TEST(Sensor, LosesTheShareOfDepthThatIsAskedFor) {
  SensorOptions options;
  options.missing_share = 0.3;
  EXPECT_NEAR(depth_statistics(seen(wall(1), options)).missing, 0.3, 0.05);
}

TEST(Sensor, ColourNoiseAndExposureAreThoseOfTheOptions) {
  SensorOptions options;
  options.colour_noise = 3;
  options.exposure_amplitude = 0.1;
  options.exposure_period = 4;
  options.exposure_jump = 1.5;
  options.exposure_jump_time = 3.5;
  const Statistics start = colour_statistics(seen(wall(1), options, 0));
  EXPECT_NEAR(start.mean, 100, 0.1);
  EXPECT_NEAR(start.sigma, 3, 0.1);
  EXPECT_NEAR(colour_statistics(seen(wall(1), options, 1)).mean, 110, 0.1);
  EXPECT_NEAR(colour_statistics(seen(wall(1), options, 3)).mean, 90, 0.1);
  EXPECT_NEAR(colour_statistics(seen(wall(1), options, 4)).mean, 150, 0.1);
}

TEST(Sensor, LessLightGivesTheSameBrightnessWithMoreNoise) {
  SensorOptions options;
  options.colour_noise = 1;
  options.shot_noise = 0.04;
  EXPECT_NEAR(colour_statistics(seen(wall(1), options)).sigma, std::sqrt(1 + 4), 0.1);
  options.light = 0.25;
  const Statistics dark = colour_statistics(seen(wall(1), options));
  EXPECT_NEAR(dark.mean, 100, 0.2);
  EXPECT_NEAR(dark.sigma, std::sqrt(16 + 16), 0.2);
}

TEST(Sensor, VignettingDarkensTheCornersOnly) {
  SensorOptions options;
  options.vignetting = 0.5;
  options.colour_noise = 0;
  const RgbdImage image = seen(wall(1), options);
  EXPECT_NEAR(image.bgr(0, 0)[0], 50, 1);
  EXPECT_NEAR(image.bgr(kSide / 2, kSide / 2)[0], 100, 1);
}

TEST(Sensor, WithoutNoisePassesThePictureOn) {
  SensorOptions options;
  options.noise = false;
  options.missing_share = 0.5;
  const Render exact = picture([](int x, int y) { return 0.1 + 0.05 * x + 0.01 * y; });
  const RgbdImage image = seen(exact, options, 3);
  EXPECT_EQ(cv::countNonZero(image.depth != exact.depth), 0);
  EXPECT_EQ(image.bgr(5, 5), cv::Vec3b::all(100));
}

TEST(Sensor, NoiseOfFramesIsIndependent) {
  const RgbdImage a = seen(wall(2), {}, 0, 1), b = seen(wall(2), {}, 0, 2);
  const Statistics difference =
      statistics([&](int x, int y) { return a.depth(y, x) - b.depth(y, x); });
  EXPECT_NEAR(difference.sigma, std::sqrt(2) * 1.4e-3 * 4, 0.15 * 1.4e-3 * 4);
}

}  // namespace
}  // namespace edvo::synth
