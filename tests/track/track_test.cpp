// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/frame/frame.hpp"
#include "edvo/track/levenberg_marquardt.hpp"
#include "edvo/track/tracker.hpp"
#include "edvo/track/turn.hpp"
#include "edvo/track/window_system.hpp"
#include "support/matchers.hpp"
#include "support/synthetic_plane.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

using test::kVgaCamera;
using test::NearPose;
using test::SyntheticPlane;

constexpr SyntheticPlane kPlane{.distance = 2.0};

Frame plane_frame(const SE3& world_from_camera) {
  return make_frame(test::render_plane(kPlane, kVgaCamera, world_from_camera),
                    make_undistortion({kVgaCamera, {}}), {});
}

std::vector<SelectedPixel> grid_pixels(const Frame& frame, int stride) {
  std::vector<SelectedPixel> pixels;
  for (int y = 12; y < frame.depth.rows - 12; y += stride)
    for (int x = 12; x < frame.depth.cols - 12; x += stride)
      pixels.push_back({{x, y}, frame.depth(y, x), 1.F});
  return pixels;
}

SE3 motion(double x, double y, double z, double a, double b, double c) {
  Vector6d xi;
  xi << x, y, z, a, b, c;
  return exp(xi);
}

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
  EXPECT_NEAR(undistort_depth(undistortion, depth)(100, 500), 1 + 0.001 * u, 0.0006);
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
  const Reference reference = make_reference(frame, pixels, {.softness = 40});
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

struct Parabola {  // cost 0.5 |x - 3|^2 in one unknown, padded
  [[nodiscard]] LinearSystem<1> linearize(double x) const {
    LinearSystem<1> system;
    system.hessian(0, 0) = 1;
    system.gradient[0] = x - 3;
    system.cost = 0.5 * (x - 3) * (x - 3);
    ++calls;
    return system;
  }
  [[nodiscard]] double update(double x, const Eigen::Matrix<double, 1, 1>& d) const {
    return x + d[0];
  }
  [[nodiscard]] double step_size(const Eigen::Matrix<double, 1, 1>& d) const {
    return std::abs(d[0]);
  }
  mutable int calls = 0;
};

TEST(LevenbergMarquardt, FindsTheMinimum) {
  double x = -50;
  const auto summary = minimize(Parabola{}, x, {.step_tolerance = 1e-9});
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(x, 3, 1e-6);
}

TEST(LevenbergMarquardt, LambdaReachesTheSolver) {
  double x = 0;
  (void)minimize(Parabola{}, x, {.max_iterations = 2, .initial_lambda = 9});
  EXPECT_NEAR(x, 0.3, 1e-12);  // one step of 3 / (1 + 9)
}

struct Wall : Parabola {  // every step makes it worse
  [[nodiscard]] LinearSystem<1> linearize(double x) const {
    LinearSystem<1> system = Parabola::linearize(x);
    if (x != 0) system.cost = 1e9;
    return system;
  }
};

TEST(LevenbergMarquardt, ARejectedStepLeavesNoTrace) {
  double x = 0;
  (void)minimize(Wall{}, x, {.max_iterations = 20});
  EXPECT_EQ(x, 0);
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
  std::vector<float> residuals;
  for (int i = 1; i < 1000; ++i)
    residuals.push_back(5.F * static_cast<float>(std::tan((i - 500) * 0.0005)));
  std::vector<float> with_outliers = residuals;
  with_outliers.insert(with_outliers.end(), 100, 1e6F);
  const float sigma = mad_sigma(residuals);
  EXPECT_NEAR(mad_sigma(with_outliers), sigma, 0.25F * sigma);
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
  EXPECT_EQ(mad_sigma(residuals), 1.4826F * sizes[250]);
  EXPECT_EQ(mad_sigma({}), 0);
}

TEST(Shift, IsHowFarPosesMoveThePointsApartInWidthsOfTheImage) {
  const Frame frame = plane_frame(SE3{});
  const Reference reference = make_reference(frame, grid_pixels(frame, 20), {});
  const SE3 still, aside{.translation = {0.1, 0, 0}};
  EXPECT_DOUBLE_EQ(shift(reference, 0, aside, aside), 0);
  const double expected = kVgaCamera.fx * 0.1 / kPlane.distance / kVgaCamera.width;
  EXPECT_NEAR(shift(reference, 0, still, aside), expected, 0.01 * expected);
  EXPECT_NEAR(shift(reference, 1, still, aside), expected, 0.01 * expected);
}

TEST(Tracker, RecoversAMotionOnAPlane) {
  const Frame key = plane_frame({});
  Reference reference = make_reference(key, grid_pixels(key, 9), {});
  for (const SE3& truth :
       {motion(0.05, 0, 0, 0, 0, 0), motion(0, -0.04, 0.03, 0, 0, 0),
        motion(0, 0, 0, 0.03, -0.02, 0.05), motion(0.02, 0.03, -0.05, 0.02, 0.01, -0.03)}) {
    const TrackResult result = track(reference, plane_frame(truth), {}, {});
    EXPECT_EQ(result.status, TrackStatus::kTracked);
    EXPECT_THAT(result.alignment.cur_from_ref, NearPose(inverse(truth), 1e-3));
  }
}

TEST(Tracker, EstimatesGainAndBias) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  RgbdImage darker = test::render_plane(kPlane, kVgaCamera, motion(0.02, 0, 0, 0, 0.01, 0));
  darker.bgr.convertTo(darker.bgr, -1, 0.7, 12);
  const TrackResult result =
      track(reference, make_frame(darker, make_undistortion({kVgaCamera, {}}), {}), {}, {});
  EXPECT_NEAR(result.alignment.gain, 0.7, 0.02);
  EXPECT_NEAR(result.alignment.bias, 12, 2.5);
  EXPECT_THAT(result.alignment.cur_from_ref,
              NearPose(inverse(motion(0.02, 0, 0, 0, 0.01, 0)), 2e-3));
}

TEST(Tracker, SaysLostOnAnUnrelatedImage) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  Frame black = key;
  for (Level& level : black.levels)
    level.gray = cv::Mat_<std::uint8_t>(level.gray.size(), std::uint8_t{0});
  black.depth = cv::Mat_<float>(key.depth.size(), std::numeric_limits<float>::quiet_NaN());
  const TrackResult result = track(reference, black, {}, {.brightness = false});
  EXPECT_EQ(result.status, TrackStatus::kLost);
  EXPECT_TRUE(is_finite(result.alignment.cur_from_ref));
}

TEST(Surface, SigmaIsTheNoiseOfTheSensorOnceAligned) {
  const SE3 moved = motion(0.03, 0.01, -0.02, 0.01, -0.01, 0.005);
  const Frame key = plane_frame({}), current = plane_frame(moved);
  const SurfacePoints surface = make_surface(key.depth, kVgaCamera, 12, 0.003);
  std::vector<float> room;
  EXPECT_LT(surface_sigma(surface, kVgaCamera, current.depth, inverse(moved), room), 1e-4F);
  EXPECT_GT(surface_sigma(surface, kVgaCamera, current.depth, SE3{}, room), 3e-3F);
  cv::Mat_<float> noisy = current.depth.clone();
  constexpr double kSigma = 0.002;  // [1 / m]
  cv::RNG random(7);
  for (float& z : noisy) z = 1 / (1 / z + static_cast<float>(random.gaussian(kSigma)));
  EXPECT_NEAR(surface_sigma(surface, kVgaCamera, noisy, inverse(moved), room), kSigma, 3e-4);
  EXPECT_EQ(surface_sigma({}, kVgaCamera, noisy, SE3{}, room), 0.F);
}

TEST(Tracker, InformationIsSymmetricAndPositive) {
  const Frame key = plane_frame({});
  const Reference reference = make_reference(key, grid_pixels(key, 9), {});
  const Matrix6d information = track(reference, key, {}, {}).information;
  EXPECT_LT((information - information.transpose()).norm(), 1e-6 * information.norm());
  EXPECT_GT(information.ldlt().vectorD().minCoeff(), 0);
}

TEST(Turn, IsFoundFromAShiftThatGradientsDoNotTell) {
  const Camera camera{.fx = 32, .fy = 32, .cx = 19.5, .cy = 14.5, .width = 40, .height = 30};
  cv::Mat_<std::uint8_t> wide(60, 80);
  cv::RNG random(3);
  random.fill(wide, cv::RNG::UNIFORM, 0, 256);
  const cv::Mat_<std::uint8_t> before = wide(cv::Rect(20, 15, 40, 30));
  const cv::Mat_<std::uint8_t> now = wide(cv::Rect(20 - 9, 15 + 5, 40, 30));  // all moves (9, -5)
  PhaseCorrelation correlation;
  correlation.shift_to(before);
  const SE3 turn = turn_of(correlation.shift_to(now), camera);
  const Eigen::Vector3d moved = turn * Eigen::Vector3d(0, 0, 1);
  EXPECT_NEAR(moved.x() / moved.z() * camera.fx, 9, 1);
  EXPECT_NEAR(moved.y() / moved.z() * camera.fy, -5, 1);
}

TEST(Turn, IsNoneBetweenBlankImages) {
  const cv::Mat_<std::uint8_t> blank(30, 40, std::uint8_t{90});
  PhaseCorrelation correlation;
  correlation.shift_to(blank);
  EXPECT_LT(cv::norm(correlation.shift_to(blank)), 1e-6);
}

TEST(Turn, ShiftsAreThoseOfOpenCv) {
  cv::Mat_<std::uint8_t> scene(120, 160);
  cv::RNG random(5);
  random.fill(scene, cv::RNG::UNIFORM, 0, 256);
  for (const cv::Size size : {cv::Size(40, 30), cv::Size(62, 46)}) {
    PhaseCorrelation correlation;
    cv::Mat before, window;
    cv::createHanningWindow(window, size, CV_32F);
    for (int i = 0; i < 4; ++i) {
      const cv::Mat_<std::uint8_t> image = scene(cv::Rect({20 + 3 * i, 30 - 2 * i * i}, size));
      cv::Mat now;
      image.convertTo(now, CV_32F);
      const cv::Point2d shift = correlation.shift_to(image);
      const cv::Point2d expected =
          i == 0 ? cv::Point2d() : cv::phaseCorrelate(before, now.clone(), window);
      EXPECT_LT(cv::norm(shift - expected), 1e-4) << size << ' ' << i;
      image.convertTo(before, CV_32F);
    }
  }
}

TEST(Turn, ShiftsAreRightInImagesOfOddSize) {  // where OpenCV's are half a pixel off
  cv::Mat_<std::uint8_t> scene(120, 160);
  cv::RNG random(5);
  random.fill(scene, cv::RNG::UNIFORM, 0, 256);
  PhaseCorrelation correlation;
  correlation.shift_to(scene(cv::Rect(20, 30, 75, 45)));
  const cv::Point2d shift = correlation.shift_to(scene(cv::Rect(17, 32, 75, 45)));
  EXPECT_LT(cv::norm(shift - cv::Point2d(3, -2)), 0.3);
}

TEST(Selection, TakesTheForegroundAtADepthJump) {
  cv::Mat_<float> depth(40, 40, 3.F);
  depth(cv::Rect(0, 0, 20, 40)) = 1.F;
  std::vector<float> depths;
  edge_depths(depth, 20, {}, depths);
  EXPECT_EQ(depths[21], 1.F);
  EXPECT_EQ(depths[30], 3.F);
  edge_depths(depth, 20, {.foreground = false}, depths);
  EXPECT_TRUE(std::isnan(depths[21]));
}

TEST(Selection, DepthsMissingAroundAPixelAreNoJump) {
  cv::Mat_<float> depth(40, 40, 2.F);
  depth(19, 20) = depth(20, 22) = std::numeric_limits<float>::quiet_NaN();
  depth(22, 29) = 1.5F;
  std::vector<float> depths;
  edge_depths(depth, 20, {}, depths);
  EXPECT_EQ(depths[20], 2.F);
  EXPECT_TRUE(std::isnan(depths[22]));
  EXPECT_EQ(depths[27], 1.5F);  // as far as jump_radius
  EXPECT_EQ(depths[26], 2.F);
  edge_depths(depth, 20, {.max_depth = 1.8}, depths);
  EXPECT_TRUE(std::isnan(depths[20]));
}

TEST(Selection, SpreadTakesOneOfEveryCellBeforeTheSecondOfAny) {
  std::vector<SelectedPixel> pixels;
  for (int x = 0; x < 80; ++x) pixels.push_back({{x, 4}, 1.F, static_cast<float>(x % 10)});
  const auto kept = spread(pixels, 80, 10, 8);
  ASSERT_EQ(kept.size(), 8U);
  for (int cell = 0; cell < 8; ++cell)
    EXPECT_EQ(kept[static_cast<std::size_t>(cell)].pixel.x, 10 * cell + 9);
}

std::vector<WindowKeyframe> plane_window(const std::vector<SE3>& poses,
                                         const WindowOptions& options) {
  std::vector<WindowKeyframe> window;
  for (const SE3& pose : poses) {
    const Frame frame = plane_frame(pose);
    window.push_back(make_window_keyframe(frame, pose, grid_pixels(frame, 41), options));
  }
  return window;
}

TEST(Window, RecoversDisturbedPosesAndBrightness) {
  const WindowOptions options{.iterations = 20, .tolerance = 1e-9};
  const std::vector<SE3> poses = {SE3{}, motion(0.1, 0, 0, 0, 0.02, 0),
                                  motion(0.1, 0.1, 0.05, 0.02, 0, 0.03)};
  auto window = plane_window(poses, options);
  window[1].world_from_key = poses[1] * motion(0.004, -0.003, 0.004, 0.001, 0.002, -0.002);
  window[2].world_from_key = poses[2] * motion(-0.004, 0.005, 0.002, 0.002, -0.001, 0.001);
  std::vector<PairModel> memory;
  const WindowSummary summary = refine_window(window, kVgaCamera, 1, options, memory);
  EXPECT_LT(summary.last_cost, summary.first_cost);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_THAT(window[k].world_from_key, NearPose(poses[k], 1.5e-3));
    EXPECT_NEAR(window[k].gain, 1, 0.02);
  }
}

TEST(Window, LeavesTheFixedKeyframesWhereTheyAre) {
  const WindowOptions options;
  const std::vector<SE3> poses = {SE3{}, motion(0.05, 0, 0, 0, 0, 0), motion(0.1, 0, 0, 0, 0, 0)};
  auto window = plane_window(poses, options);
  window[2].world_from_key = poses[2] * motion(0.003, 0, 0, 0, 0, 0);
  std::vector<PairModel> memory;
  (void)refine_window(window, kVgaCamera, 2, options, memory);
  EXPECT_THAT(window[0].world_from_key, NearPose(poses[0], 1e-15));
  EXPECT_THAT(window[1].world_from_key, NearPose(poses[1], 1e-15));
}

// Three views of a plane, the last two a little off.
std::vector<WindowKeyframe> disturbed_window(const WindowOptions& options) {
  const std::vector<SE3> poses = {SE3{}, motion(0.06, 0.02, 0, 0, 0.01, 0),
                                  motion(0.08, 0.06, 0.04, 0.01, 0, 0.03)};
  auto window = plane_window(poses, options);
  window[1].world_from_key = poses[1] * motion(0.002, -0.001, 0.002, 0.001, 0.001, -0.001);
  window[2].world_from_key = poses[2] * motion(-0.002, 0.002, 0.001, 0.001, -0.001, 0.001);
  return window;
}

// All pairs anew.
WindowSystem linearized(const std::vector<WindowKeyframe>& window, WindowPairs pairs,
                        const WindowOptions& options) {
  std::vector<PairModel> models(window.size() * window.size());
  return linearize_window(window, kVgaCamera, 1, pairs, options, models);
}

class WindowCost : public testing::TestWithParam<WindowPairs> {};

TEST_P(WindowCost, GradientMatchesNumericDifferences) {
  const WindowOptions options{.geometric = 0};
  const auto window = disturbed_window(options);
  const WindowSystem system = linearized(window, GetParam(), options);
  constexpr double kStep = 1e-4;
  for (int k = 0; k < 12; ++k) {
    const auto cost = [&](double step) {
      auto moved = window;
      Vector6d xi = Vector6d::Zero();
      xi[k % 6] = step;
      auto& pose = moved[static_cast<std::size_t>(1 + k / 6)].world_from_key;
      pose = pose * exp(xi);
      return linearized(moved, GetParam(), options).cost;
    };
    const double numeric = (cost(kStep) - cost(-kStep)) / (2 * kStep);
    const Vector6d gradient = system.gradient.segment<6>(8 * (k / 6));  // of this pose
    EXPECT_NEAR(gradient[k % 6], numeric, 0.05 * gradient.norm()) << k;
  }
}

TEST_P(WindowCost, MovesByAStepAsItsGradientSays) {
  const WindowOptions options{};
  auto window = disturbed_window(options);
  const WindowSystem newest = linearized(window, WindowPairs::kNewest, options);
  WindowSystem system = linearized(window, WindowPairs::kOthers, options);
  WindowStep step = solve(newest, system, 0);
  if (GetParam() == WindowPairs::kNewest) system = newest;
  apply_step(step, 1, window);
  const WindowSystem before = system;
  move_by(step, system);
  const WindowSystem there = linearized(window, GetParam(), options);
  EXPECT_LT((system.gradient - there.gradient).norm(),
            0.2 * (before.gradient - there.gradient).norm());
  // Exact for a quadratic: the mean of the gradients at both ends times the step.
  double change = 0.5 * step.keyframes.dot(before.gradient + system.gradient);
  for (std::size_t i = 0; i < step.depths.size(); ++i)
    change += 0.5 * static_cast<double>(step.depths[i] *
                                        (before.depths[i].gradient + system.depths[i].gradient));
  EXPECT_NEAR(system.cost - before.cost, change, 1e-3 * std::abs(change));
}

INSTANTIATE_TEST_SUITE_P(Pairs, WindowCost,
                         testing::Values(WindowPairs::kNewest, WindowPairs::kOthers));

TEST(Window, AModelIsMovedWithSmallStepsAndMadeAnewAfterLargeOnes) {
  const WindowOptions options{};
  const PairConstants constants = pair_constants(kVgaCamera, options);
  constexpr double kLimit = 0.3;  // [px]
  auto window = disturbed_window(options);
  WindowKeyframe &host = window[1], &target = window[2];
  PairModel before;
  update_pair(constants, host, target, kLimit, before);
  const auto move = [&](double share) {  // of a step of 0.2 px or so
    host.world_from_key = host.world_from_key * motion(share * 5e-4, 0, share * 4e-4, 0, 0, 0);
    host.gain += share * 0.01;
    target.world_from_key = target.world_from_key * motion(0, 0, 0, share * 2e-4, 0, 0);
    target.gain -= share * 0.005;
    target.bias += share * 0.5;
    for (WindowPoint& point : host.points) point.inverse_depth += share * 1e-4;
  };
  const auto size = [](const PairSums& a, const PairSums& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.gradient.size(); ++k)
      sum += std::abs(a.gradient[k] - b.gradient[k]);
    return sum;
  };
  move(1);
  PairModel moved = before, anew;
  update_pair(constants, host, target, kLimit, moved);
  update_pair(constants, host, target, kLimit, anew);
  EXPECT_EQ(moved.sums.hessian, before.sums.hessian);
  EXPECT_LT(size(moved.sums, anew.sums), 0.25 * size(before.sums, anew.sums));
  EXPECT_LT(std::abs(moved.cost - anew.cost), 0.25 * std::abs(before.cost - anew.cost));
  move(10);
  update_pair(constants, host, target, kLimit, moved);
  update_pair(constants, host, target, 0, anew);
  EXPECT_EQ(moved.sums.gradient, anew.sums.gradient);
  EXPECT_EQ(moved.coupling, anew.coupling);
}

TEST(Window, RefinesToTheSamePosesFromModelsRemembered) {
  const WindowOptions options;
  std::vector<WindowKeyframe> window = disturbed_window(options);
  for (std::size_t k = 0; k < window.size(); ++k)
    window[k].stamp = stamp_from_seconds(static_cast<double>(k));
  std::vector<PairModel> memory;
  (void)refine_window(window, kVgaCamera, 1, options, memory);
  EXPECT_EQ(memory.size(), 6U);
  // A fourth keyframe replaces the first.
  const SE3 pose = motion(0.1, 0.05, 0.06, 0.01, 0.01, 0.02);
  window.erase(window.begin());
  window.push_back(plane_window({pose}, options).front());
  window.back().stamp = stamp_from_seconds(3);
  auto without = window;
  std::vector<PairModel> nothing;
  (void)refine_window(window, kVgaCamera, 1, options, memory);
  (void)refine_window(without, kVgaCamera, 1, options, nothing);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_THAT(window[k].world_from_key, NearPose(without[k].world_from_key, 1e-4));
  for (const PairModel& model : memory) EXPECT_GE(model.host, stamp_from_seconds(1));
}

TEST(Window, AnotherKeyframesViewIsSharedOnlyIfItLooksThere) {
  const auto window =
      plane_window({SE3{}, motion(0.2, 0, 0, 0, 0, 0), motion(0, 0, 0, 0, 2, 0)}, {});
  EXPECT_EQ(shared_view(window[0], window[0], kVgaCamera), 1);
  EXPECT_GT(shared_view(window[0], window[1], kVgaCamera), 0.7);
  EXPECT_EQ(shared_view(window[0], window[2], kVgaCamera), 0);
}

}  // namespace
}  // namespace edvo
