// SPDX-License-Identifier: MIT
#include "edvo/image/depth.hpp"

#include "edvo/core/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

const DistortedCamera kBarrel{.pinhole = {260, 258, 159.3, 127.6, 323, 241},
                              .distortion = {0.26, -0.95, -0.005, 0.003, 1.16}};
const DistortedCamera kPincushion{.pinhole = {260, 258, 159.3, 127.6, 323, 241},
                                  .distortion = {-0.3, 0.1, 0.001, 0.002, 0}};

cv::Mat noise_image(int type) {
  cv::Mat image(241, 323, type);
  cv::RNG rng(7);
  rng.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

// Where each pixel comes from, by Brown's model.
cv::Mat_<cv::Vec2f> brown_map(const DistortedCamera& camera) {
  const auto& [fx, fy, cx, cy, width, height] = camera.pinhole;
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  cv::Mat_<cv::Vec2f> map(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const double x = (u - cx) / fx, y = (v - cy) / fy, r2 = x * x + y * y;
      const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
      const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
      const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
      map(v, u) = {static_cast<float>(fx * xd + cx), static_cast<float>(fy * yd + cy)};
    }
  return map;
}

struct Lens {
  const char* name;
  DistortedCamera camera;

  friend void PrintTo(const Lens& lens, std::ostream* out) { *out << lens.name; }
};

class Undistort : public testing::TestWithParam<Lens> {};

TEST_P(Undistort, AgreesWithOpenCvToTheBit) {
  cv::Mat map, interpolation;
  cv::convertMaps(brown_map(GetParam().camera), cv::noArray(), map, interpolation, CV_16SC2);
  const Undistortion undistortion = make_undistortion(GetParam().camera);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat image = noise_image(type);
    cv::Mat expected;
    cv::remap(image, expected, map, interpolation, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    EXPECT_EQ(cv::norm(undistort_colour(undistortion, image), expected, cv::NORM_INF), 0);
  }
}

TEST_P(Undistort, ReadsAViewOfALargerImageAlike) {
  const Undistortion undistortion = make_undistortion(GetParam().camera);
  const cv::Mat image = noise_image(CV_8UC1);
  cv::Mat larger;
  cv::copyMakeBorder(image, larger, 3, 4, 5, 6, cv::BORDER_CONSTANT);
  const cv::Mat view = larger(cv::Rect(5, 3, image.cols, image.rows));
  EXPECT_EQ(cv::norm(undistort_colour(undistortion, view), undistort_colour(undistortion, image),
                     cv::NORM_INF),
            0);
}

TEST_P(Undistort, DepthIsNeverAveragedAndNoneBeyondTheSensor) {
  const Undistortion undistortion = make_undistortion(GetParam().camera);
  cv::Mat_<float> depth(241, 323);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) depth(y, x) = (x + y) % 2 == 0 ? 1.F : 3.F;
  const Depth looked_up(undistortion, depth);
  const cv::Mat_<float> result = looked_up.undistorted();
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const float z = result(y, x);
      ASSERT_THAT(looked_up(y, x), testing::NanSensitiveFloatEq(z));
      ASSERT_TRUE(z == 1.F || z == 3.F || std::isnan(z));
      if (undistortion.valid(y, x) != 0) {
        ASSERT_FALSE(std::isnan(z));
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Lenses, Undistort,
                         testing::Values(Lens{"Barrel", kBarrel}, Lens{"Pincushion", kPincushion}),
                         [](const auto& lens) { return std::string(lens.param.name); });

TEST(UndistortPinhole, LeavesImagesAsTheyAre) {
  const Undistortion undistortion = make_undistortion({.pinhole = kBarrel.pinhole});
  const cv::Mat image = noise_image(CV_8UC3);
  EXPECT_EQ(undistort_colour(undistortion, image).data, image.data);
}

TEST(UndistortPinhole, NeedsASize) {
  EXPECT_THROW((void)make_undistortion({.pinhole = {260, 258, 159, 127, 0, 241}}), Error);
}

}  // namespace
}  // namespace edvo
