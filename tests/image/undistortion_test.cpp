// SPDX-License-Identifier: MIT
#include "edvo/image/depth.hpp"

#include "edvo/core/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

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

// Azure Kinect's model: eight coefficients, none of them small.
const DistortedCamera kRational{.pinhole = {260, 258, 159.3, 127.6, 323, 241},
                                .distortion = {0.5, -2.6, 0.0005, -0.0002, 1.5, 0.4, -2.4, 1.4}};
const DistortedCamera kFisheye{.pinhole = {150, 148, 159.3, 127.6, 323, 241},
                               .distortion = {-0.02, 0.01, -0.003, 0.0005},
                               .lens = LensModel::kEquidistant};

// Where each pixel comes from: OpenCV's formula for up to eight coefficients.
cv::Mat_<cv::Vec2f> polynomial_map(const DistortedCamera& camera) {
  const auto& [fx, fy, cx, cy, width, height] = camera.pinhole;
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = camera.distortion;
  cv::Mat_<cv::Vec2f> map(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const double x = (u - cx) / fx, y = (v - cy) / fy, r2 = x * x + y * y;
      const double radial =
          (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)));
      const double xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
      const double yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
      map(v, u) = {static_cast<float>(fx * xd + cx), static_cast<float>(fy * yd + cy)};
    }
  return map;
}

// As documented for OpenCV's fisheye module: an angle of theta is bent to
// theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
cv::Mat_<cv::Vec2f> equidistant_map(const DistortedCamera& camera) {
  const auto& [fx, fy, cx, cy, width, height] = camera.pinhole;
  cv::Mat_<cv::Vec2f> map(height, width);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      const double x = (u - cx) / fx, y = (v - cy) / fy, r = std::sqrt(x * x + y * y);
      const double theta = std::atan(r);
      double bent = theta;
      for (int i = 0; i < 4; ++i) bent += camera.distortion[i] * std::pow(theta, 2 * i + 3);
      map(v, u) = {static_cast<float>(fx * x * bent / r + cx),
                   static_cast<float>(fy * y * bent / r + cy)};
    }
  return map;
}

cv::Mat_<cv::Vec2f> expected_map(const DistortedCamera& camera) {
  return camera.lens == LensModel::kEquidistant ? equidistant_map(camera) : polynomial_map(camera);
}

struct Lens {
  const char* name;
  DistortedCamera camera;

  friend void PrintTo(const Lens& lens, std::ostream* out) { *out << lens.name; }
};

class Undistort : public testing::TestWithParam<Lens> {};

TEST_P(Undistort, AgreesWithOpenCvToTheBit) {
  cv::Mat map, interpolation;
  cv::convertMaps(expected_map(GetParam().camera), cv::noArray(), map, interpolation, CV_16SC2);
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
                         testing::Values(Lens{"Barrel", kBarrel}, Lens{"Pincushion", kPincushion},
                                         Lens{"Rational", kRational}, Lens{"Fisheye", kFisheye}),
                         [](const auto& lens) { return std::string(lens.param.name); });

struct Sample {
  double u, v;                // [px] in the undistorted image
  double source_u, source_v;  // [px] in the distorted one
};

class DistortAsOpenCv : public testing::TestWithParam<std::pair<Lens, std::vector<Sample>>> {};

TEST_P(DistortAsOpenCv, ToAThousandthOfAPixel) {
  const auto& [lens, samples] = GetParam();
  const Camera& c = lens.camera.pinhole;
  for (const Sample& s : samples) {
    const Eigen::Vector2d at = distort(lens.camera, {(s.u - c.cx) / c.fx, (s.v - c.cy) / c.fy});
    EXPECT_NEAR(c.fx * at.x() + c.cx, s.source_u, 1e-3);
    EXPECT_NEAR(c.fy * at.y() + c.cy, s.source_v, 1e-3);
  }
}

// What initUndistortRectifyMap() and fisheye::initUndistortRectifyMap() of OpenCV 4.10 give.
INSTANTIATE_TEST_SUITE_P(
    Lenses, DistortAsOpenCv,
    testing::Values(
        std::pair{Lens{"Rational", kRational}, std::vector<Sample>{{40, 200, 38.0922, 201.1860},
                                                                   {160, 128, 160, 128},
                                                                   {250, 60, 251.0867, 59.2072},
                                                                   {300, 220, 302.3412, 221.6062},
                                                                   {100, 20, 99.1917, 18.5838}}},
        std::pair{Lens{"Fisheye", kFisheye}, std::vector<Sample>{{40, 200, 64.1534, 185.3420},
                                                                 {160, 128, 160, 128},
                                                                 {250, 60, 236.3836, 70.1485},
                                                                 {300, 220, 263.7367, 196.1853},
                                                                 {100, 20, 110.1377, 38.3948}}}),
    [](const auto& lens) { return std::string(lens.param.first.name); });

TEST(UndistortPinhole, LeavesImagesAsTheyAre) {
  const Undistortion undistortion = make_undistortion({.pinhole = kBarrel.pinhole});
  const cv::Mat image = noise_image(CV_8UC3);
  EXPECT_EQ(undistort_colour(undistortion, image).data, image.data);
}

TEST(UndistortPinhole, AnEquidistantLensIsNoneEvenWithoutCoefficients) {
  const DistortedCamera camera{.pinhole = kBarrel.pinhole, .lens = LensModel::kEquidistant};
  EXPECT_TRUE(is_distorted(camera));
  EXPECT_FALSE(make_undistortion(camera).corner.empty());
}

TEST(UndistortPinhole, NeedsASize) {
  EXPECT_THROW((void)make_undistortion({.pinhole = {260, 258, 159, 127, 0, 241}}), Error);
}

}  // namespace
}  // namespace edvo
