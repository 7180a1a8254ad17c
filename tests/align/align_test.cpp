// SPDX-License-Identifier: MIT
#include "edvo/align/align.hpp"
#include "edvo/align/bilinear.hpp"
#include "edvo/core/error.hpp"
#include "edvo/image/frame.hpp"
#include "edvo/simd/float8.hpp"
#include "support/matchers.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>

namespace edvo {
namespace {

using test::grid_pixels;
using test::kPlane;
using test::kVgaCamera;
using test::motion;
using test::NearPose;
using test::plane_frame;

TEST(Undistortion, OfAnUndistortedCameraIsTheImageItself) {
  const auto undistortion = make_undistortion({kVgaCamera, {}});
  const cv::Mat_<std::uint8_t> image(480, 640, std::uint8_t{7});
  EXPECT_EQ(undistort_colour(undistortion, image).data, image.data);
}

TEST(Undistortion, TakesDepthFromWhereTheDistortedCameraSawIt) {
  const DistortedCamera camera{kVgaCamera, {0.2, -0.5, 0.001, -0.002, 0.3}};
  const auto undistortion = make_undistortion(camera);
  cv::Mat_<float> depth(480, 640);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) depth(y, x) = 1.F + 0.001F * static_cast<float>(x);
  // The model by hand at one pixel.
  const double x = (500 - 319.5) / 525, y = (100 - 239.5) / 525, r2 = x * x + y * y;
  const double radial = 1 + r2 * (0.2 + r2 * (-0.5 + r2 * 0.3));
  const double u = 525 * (x * radial + 2 * 0.001 * x * y - 0.002 * (r2 + 2 * x * x)) + 319.5;
  EXPECT_NEAR(Depth(undistortion, depth)(100, 500), 1 + 0.001 * u, 0.0006);
}

TEST(Undistortion, RefusesACameraWithoutFocalLength) {
  EXPECT_THROW((void)make_undistortion({Camera{.width = 640, .height = 480}, {}}), Error);
}

TEST(Frame, PyramidKeepsPrincipalPointAndIntensityTogether) {
  const Frame frame = plane_frame({});
  constexpr std::size_t kPaperLevels = 4;  // coarser ones blur the plane's pattern itself
  for (std::size_t l = 0; l < kPaperLevels; ++l) {
    const Level& level = frame.levels[l];
    const int x = level.gray.cols / 3, y = level.gray.rows / 2;
    EXPECT_NEAR(level.gray(y, x), test::intensity_at(kPlane, level.camera, {}, x, y), 2.5) << l;
  }
}

TEST(Reference, JacobianMatchesNumericDifferencesOfTheAnalyticImage) {
  const Frame frame = plane_frame({});
  const auto pixels = grid_pixels(frame, 37);
  const Reference reference = make_reference(frame, pixels, {.gradient_weight_scale = 40});
  const ReferenceLevel& level = reference.levels[0];
  constexpr double kStep = 1e-5;
  for (std::size_t i = 0; i < level.count; ++i)
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector3d p(level.x[i], level.y[i], level.z[i]);
      const auto intensity = [&](double step) {
        Vector6d xi = Vector6d::Zero();
        xi[k] = step;
        const Eigen::Vector2d pixel = project(kVgaCamera, exp(xi) * p);
        return test::intensity_at(kPlane, kVgaCamera, {}, pixel.x(), pixel.y());
      };
      const double numeric = (intensity(kStep) - intensity(-kStep)) / (2 * kStep);
      EXPECT_NEAR(level.jacobian[static_cast<std::size_t>(k)][i], numeric,
                  0.02 * std::abs(numeric) + 400)  // half a grey level of rounding over 1 px
          << "point " << i << " component " << k;
    }
}

// Pixels that fill no whole block of eight, some of which lie outside of coarse levels.
TEST(Reference, HoldsThePointsThatLieInsideEachLevel) {
  const Frame frame = plane_frame({});
  std::vector<SelectedPixel> pixels;
  for (const cv::Point p : {cv::Point{300, 200},
                            {5, 240},
                            {40, 41},
                            {634, 100},
                            {320, 475},
                            {601, 440},
                            {100, 99},
                            {8, 8},
                            {33, 35},
                            {310, 77},
                            {9, 300}})
    pixels.push_back({p, frame.depth(p.y, p.x), 1.F});
  const Reference reference = make_reference(frame, pixels, {});
  for (std::size_t l = 0; l < frame.levels.size(); ++l) {
    const cv::Mat_<std::uint8_t>& gray = frame.levels[l].gray;
    const ReferenceLevel& level = reference.levels[l];
    std::size_t n = 0;
    for (const SelectedPixel& pixel : pixels) {
      const float u = std::ldexp(static_cast<float>(pixel.pixel.x), -static_cast<int>(l));
      const float v = std::ldexp(static_cast<float>(pixel.pixel.y), -static_cast<int>(l));
      if (!inside(gray, u, v, 1)) continue;
      ASSERT_LT(n, level.count) << l;
      EXPECT_EQ(level.z[n], pixel.depth);
      EXPECT_NEAR(level.intensity[n], bilinear(gray, u, v), 1e-3F) << l << ' ' << n;
      ++n;
    }
    EXPECT_EQ(level.count, n) << l;
    EXPECT_EQ(level.x.size() % simd::kWidth, 0U);
    for (std::size_t k = n; k < level.x.size(); ++k) EXPECT_EQ(level.z[k], 0.F);
  }
}

TEST(Photometric, CostIsTheWeightedSumOfLossesAndOfTheOutsideOnes) {
  const Frame key = plane_frame({}), current = plane_frame(motion(0.1, 0.02, -0.01, 0, 0, 0.01));
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  const ReferenceLevel& points = reference.levels[0];
  std::vector<float> residuals;
  photometric_residuals(points, current.levels[0], Vector6d::Zero(), {}, residuals);
  residuals[3] = std::numeric_limits<float>::quiet_NaN();  // out of view
  constexpr float kSigma = 4, kParameter = 2;
  for (const Loss loss : {Loss::kHuber, Loss::kStudent, Loss::kTukey}) {
    double expected = 0;
    for (std::size_t i = 0; i < points.count; ++i) {
      const float r = std::isnan(residuals[i]) ? kInlierSigmas : residuals[i] / kSigma;
      expected += static_cast<double>(points.weight[i] * robust(loss, kParameter, r).cost);
    }
    const double alone = photometric_cost(points, residuals, kSigma, loss, kParameter);
    EXPECT_NEAR(alone, expected, 1e-5 * expected) << name_of(loss);
    EXPECT_EQ(
        alone,
        sum_photometric(points, residuals, all_of(residuals), 1.1, kSigma, loss, kParameter).cost);
  }
}

TEST(Robust, WeightIsTheDerivativeOfTheCostOverTheResidual) {
  for (const Loss loss : {Loss::kHuber, Loss::kStudent, Loss::kTukey})
    for (const float r : {-9.F, -2.F, -0.3F, 0.2F, 1.F, 4.F, 20.F}) {
      const float h = 1e-2F;
      const float slope = (robust(loss, 3, r + h).cost - robust(loss, 3, r - h).cost) / (2 * h);
      EXPECT_NEAR(robust(loss, 3, r).weight * r, slope, 5e-3F) << name_of(loss) << ' ' << r;
    }
}

TEST(Robust, SigmaOfNormalResidualsIsTheirDeviation) {
  constexpr float kDeviation = 5;
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0, kDeviation);
  std::vector<float> residuals(20000);
  std::ranges::generate(residuals, [&] { return normal(random); });
  EXPECT_NEAR(mad_sigma(residuals), kDeviation, 0.02F * kDeviation);
  residuals.insert(residuals.end(), 2000, 1e6F);
  EXPECT_NEAR(mad_sigma(residuals), kDeviation, 0.2F * kDeviation);
}

TEST(Robust, SigmaIsTheMedianOfSizesWhateverTheirSignsAndLeavesNanOut) {
  std::vector<float> residuals, sizes;
  for (int i = 0; i < 501; ++i) {
    const float size = std::exp(0.03F * static_cast<float>(i * 37 % 501 - 250));
    residuals.push_back(i % 2 == 0 ? size : -size);
    sizes.push_back(size);
  }
  std::sort(sizes.begin(), sizes.end());
  residuals.insert(residuals.begin() + 100, 40, std::numeric_limits<float>::quiet_NaN());
  EXPECT_NEAR(mad_sigma(residuals), 1.4826F * sizes[250], 1e-4F * sizes[250]);
  EXPECT_EQ(mad_sigma({}), 0);
}

TEST(Shift, IsHowFarPosesMoveThePointsApartInWidthsOfTheImage) {
  const Frame frame = plane_frame(SE3{});
  const Reference reference = make_reference(frame, grid_pixels(frame, 20), {});
  const SE3 still, aside{.translation = {0.1, 0, 0}};
  EXPECT_DOUBLE_EQ(mean_flow(reference, 0, aside, aside), 0);
  const double expected = kVgaCamera.fx * 0.1 / kPlane.distance / kVgaCamera.width;
  EXPECT_NEAR(mean_flow(reference, 0, still, aside), expected, 0.01 * expected);
  EXPECT_NEAR(mean_flow(reference, 1, still, aside), expected, 0.01 * expected);
}

TEST(Tracker, RecoversAMotionOnAPlane) {
  const Frame key = plane_frame({});
  Reference reference = make_reference(key, grid_pixels(key, 9), {});
  for (const SE3& truth :
       {motion(0.05, 0, 0, 0, 0, 0), motion(0, -0.04, 0.03, 0, 0, 0),
        motion(0, 0, 0, 0.03, -0.02, 0.05), motion(0.02, 0.03, -0.05, 0.02, 0.01, -0.03)}) {
    const AlignResult result = align(reference, plane_frame(truth), {}, {});
    EXPECT_EQ(result.status, AlignStatus::kTracked);
    EXPECT_THAT(result.alignment.cur_from_ref, NearPose(inverse(truth), 1e-3));
  }
}

TEST(Tracker, FindsTheCameraWhereItIsExpectedOnlyAsFarAsThatIsCertain) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  const SE3 truth = motion(0.02, 0, 0, 0, 0.01, 0);
  const Frame frame = plane_frame(truth);
  const Eigen::Vector3d expected = truth.translation + Eigen::Vector3d(0.01, -0.02, 0.01);
  AlignScratch scratch;
  const auto centre_by = [&](double sigma) -> Eigen::Vector3d {
    const AlignResult result = align(reference, frame, {}, {}, scratch, {expected, sigma});
    return inverse(result.alignment.cur_from_ref).translation;
  };
  EXPECT_LT((centre_by(1e-6) - expected).norm(), 1e-4);
  EXPECT_LT((centre_by(0.05) - truth.translation).norm(), 1e-3);
}

TEST(Tracker, EstimatesGainAndBias) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  RgbdImage darker = test::render_plane(kPlane, kVgaCamera, motion(0.02, 0, 0, 0, 0.01, 0));
  darker.bgr.convertTo(darker.bgr, -1, 0.7, 12);
  const AlignResult result =
      align(reference, make_frame(darker, make_undistortion({kVgaCamera, {}})), {}, {});
  EXPECT_NEAR(result.alignment.gain, 0.7, 0.02);
  EXPECT_NEAR(result.alignment.bias, 12, 2.5);
  EXPECT_THAT(result.alignment.cur_from_ref,
              NearPose(inverse(motion(0.02, 0, 0, 0, 0.01, 0)), 2e-3));
}

// As much texture as the wall has, and depth, but nothing of the wall's.
TEST(Tracker, SaysLostOnAnUnrelatedImage) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  RgbdImage other = test::render_plane(kPlane, kVgaCamera, {});
  cv::RNG random(3);
  cv::Mat_<cv::Vec3b> spots(24, 32);
  random.fill(spots, cv::RNG::UNIFORM, 0, 256);
  cv::resize(spots, other.bgr, other.bgr.size(), 0, 0, cv::INTER_CUBIC);
  const AlignResult result =
      align(reference, make_frame(other, make_undistortion({kVgaCamera, {}})), {}, {});
  EXPECT_EQ(result.status, AlignStatus::kLost);
  EXPECT_TRUE(is_finite(result.alignment.cur_from_ref));
}

TEST(Surface, SigmaIsTheNoiseOfTheSensorOnceAligned) {
  const SE3 moved = motion(0.03, 0.01, -0.02, 0.01, -0.01, 0.005);
  const Frame key = plane_frame({}), current = plane_frame(moved);
  const SurfacePoints surface = make_surface(key.depth, kVgaCamera, 12, 0.003);
  const auto sigma = [&](const SurfacePoints& points, const Depth& depth, const SE3& pose) {
    DepthAssociations associations;
    associate_depth(points, kVgaCamera, depth, pose, associations);
    std::vector<float> room;
    return surface_sigma(points, associations, pose, room);
  };
  EXPECT_LT(sigma(surface, current.depth, inverse(moved)), 1e-4F);
  EXPECT_GT(sigma(surface, current.depth, SE3{}), 3e-3F);
  cv::Mat_<float> noisy = current.depth.undistorted().clone();
  constexpr double kSigma = 0.002;  // [1 / m]
  cv::RNG random(7);
  for (float& z : noisy) z = 1 / (1 / z + static_cast<float>(random.gaussian(kSigma)));
  EXPECT_NEAR(sigma(surface, noisy, inverse(moved)), kSigma, 3e-4);
  EXPECT_EQ(sigma({}, noisy, SE3{}), 0.F);
}

TEST(Surface, WhatWasSeenIsStaleOncePointsHaveMovedAPixel) {
  const Frame key = plane_frame({});
  const SurfacePoints surface = make_surface(key.depth, kVgaCamera, 12, 0.003);
  DepthAssociations associations;
  EXPECT_TRUE(associations.is_stale({}, kVgaCamera));
  associate_depth(surface, kVgaCamera, key.depth, {}, associations);
  EXPECT_FALSE(associations.is_stale(motion(0.002, 0, 0, 0, 0, 0), kVgaCamera));
  EXPECT_FALSE(associations.is_stale(motion(0, 0, 0, 0, 0.0015, 0), kVgaCamera));
  EXPECT_TRUE(associations.is_stale(motion(0.01, 0, 0, 0, 0, 0), kVgaCamera));
  EXPECT_TRUE(associations.is_stale(motion(0, 0, 0, 0, 0.003, 0), kVgaCamera));
}

TEST(Tracker, InformationIsSymmetricAndPositive) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  const Matrix6d information = align(reference, key, {}, {}).information;
  EXPECT_LT((information - information.transpose()).norm(), 1e-6 * information.norm());
  EXPECT_GT(information.ldlt().vectorD().minCoeff(), 0);
}

TEST(Selection, SpreadTakesOneOfEveryCellBeforeTheSecondOfAny) {
  std::vector<SelectedPixel> pixels;
  for (int x = 0; x < 80; ++x) pixels.push_back({{x, 4}, 1.F, static_cast<float>(x % 10)});
  const auto kept = spread(pixels, 80, 10, 8);
  ASSERT_EQ(kept.size(), 8U);
  for (int cell = 0; cell < 8; ++cell)
    EXPECT_EQ(kept[static_cast<std::size_t>(cell)].pixel.x, 10 * cell + 9);
}

}  // namespace
}  // namespace edvo
