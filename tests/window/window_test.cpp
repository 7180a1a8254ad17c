// SPDX-License-Identifier: MIT
#include "edvo/window/refinement.hpp"

#include "support/matchers.hpp"
#include "support/plane_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {

void PrintTo(WindowPairs pairs, std::ostream* out) {
  *out << (pairs == WindowPairs::kNewest ? "Newest" : "Others");
}

namespace {

using test::grid_pixels;
using test::kVgaCamera;
using test::motion;
using test::NearPose;
using test::plane_frame;

std::vector<WindowKeyframe> plane_window(const std::vector<SE3>& poses,
                                         const WindowOptions& options) {
  std::vector<WindowKeyframe> window;
  for (const SE3& pose : poses) {
    const Frame frame = plane_frame(pose);
    window.push_back(make_window_keyframe(frame, pose, grid_pixels(frame, 41), options));
  }
  return window;
}

// As if exposure had changed: grey values gain * I + bias.
Frame exposed(const Frame& frame, double gain, double bias) {
  Frame changed = frame;
  changed.levels.front().gray = frame.levels.front().gray.clone();
  changed.levels.front().gray.convertTo(changed.levels.front().gray, -1, gain, bias);
  return changed;
}

TEST(WindowKeyframe, KeepsDepthToASmallShareOfItsNoise) {
  const WindowOptions options;
  const Frame frame = plane_frame(SE3{});
  const WindowKeyframe key = make_window_keyframe(frame, SE3{}, grid_pixels(frame, 41), options);
  for (int y = 100; y < 400; y += 20)
    for (int x = 100; x < 500; x += 20)
      EXPECT_NEAR(inverse_depth_at(key, static_cast<float>(x), static_cast<float>(y)),
                  1 / frame.depth(y, x), 0.05 * options.depth_noise);
  EXPECT_TRUE(std::isnan(inverse_depth_at(key, 0, 0)));  // next to the border
}

TEST(Window, RecoversDisturbedPosesAndBrightness) {
  const WindowOptions options{.iterations = 20, .tolerance = 1e-9};
  const std::vector<SE3> poses = {SE3{}, motion(0.1, 0, 0, 0, 0.02, 0),
                                  motion(0.1, 0.1, 0.05, 0.02, 0, 0.03)};
  const std::vector<double> gains = {1, 0.9, 1.08}, biases = {0, 9, -6};
  std::vector<WindowKeyframe> window;
  for (std::size_t k = 0; k < 3; ++k) {
    const Frame frame = exposed(plane_frame(poses[k]), gains[k], biases[k]);
    window.push_back(make_window_keyframe(frame, poses[k], grid_pixels(frame, 41), options));
  }
  window[1].world_from_key = poses[1] * motion(0.004, -0.003, 0.004, 0.001, 0.002, -0.002);
  window[2].world_from_key = poses[2] * motion(-0.004, 0.005, 0.002, 0.002, -0.001, 0.001);
  std::vector<PairModel> memory;
  const Refinement done = refine_window(window, kVgaCamera, 1, options, memory);
  EXPECT_LT(done.cost, done.first_cost);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_THAT(window[k].world_from_key, NearPose(poses[k], 1.5e-3));
    EXPECT_NEAR(window[k].gain, gains[k], 0.02) << k;
    EXPECT_NEAR(window[k].bias, biases[k], 2) << k;
  }
}

// What a pair of views of one pattern, the second blurred or not, says of their motion.
PairModel pair_of(bool blur, double pair_sigma_scale) {
  const WindowOptions options{.pair_sigma_scale = pair_sigma_scale};
  Frame frame = plane_frame(SE3{});
  cv::RNG random(1);
  random.fill(frame.levels.front().gray, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(frame.levels.front().gray.clone(), frame.levels.front().gray, {}, 1, 1);
  const WindowKeyframe host = make_window_keyframe(frame, SE3{}, grid_pixels(frame, 41), options);
  WindowKeyframe target = host;
  target.gray = host.gray.clone();
  if (blur) cv::GaussianBlur(host.gray, target.gray, {}, 3, 1);
  PairModel model;
  update_pair(pair_constants(kVgaCamera, options), host, target, 0.1, model);
  return model;
}

TEST(Window, AKeyframeThatIsBlurredSaysLess) {
  const auto information = [](const PairModel& model) { return model.sums.hessian[0]; };
  const PairModel blurred = pair_of(true, 0.6);
  const float times = 0.6F * blurred.sigma / static_cast<float>(WindowOptions{}.sigma);
  ASSERT_GT(times, 1.5F);
  // Huber's weights are larger where sigma is, so not quite times^2.
  EXPECT_LT(information(blurred), information(pair_of(true, 0)) / times);
  EXPECT_EQ(information(pair_of(false, 0.6)), information(pair_of(false, 0)));
}

TEST(Window, IsRefinedInPartsToTheSamePosesAsAtOnce) {
  const WindowOptions options{.iterations = 4, .tolerance = 0};
  auto window = plane_window({SE3{}, motion(0.1, 0, 0, 0, 0.02, 0)}, options);
  window[1].world_from_key =
      window[1].world_from_key * motion(0.004, -0.003, 0.004, 0.001, 0.002, -0.002);
  auto whole = window;
  std::vector<PairModel> memory, of_whole;
  (void)refine_window(whole, kVgaCamera, 1, options, of_whole);
  Refinement refinement = begin_refinement(window, kVgaCamera, 1, options, memory);
  int parts = 0;
  for (; !refinement.finished; ++parts) advance(refinement, window, 2, memory);
  EXPECT_EQ(parts, 2);
  EXPECT_EQ(refinement.iterations, options.iterations);
  EXPECT_THAT(window[1].world_from_key, NearPose(whole[1].world_from_key, 1e-15));
}

TEST(Window, IsFinishedWhereAStepGainsLittle) {
  const WindowOptions options{.iterations = 100};
  auto window = plane_window({SE3{}, motion(0.1, 0, 0, 0, 0.02, 0)}, options);
  window[1].world_from_key =
      window[1].world_from_key * motion(0.004, -0.003, 0.004, 0.001, 0.002, -0.002);
  std::vector<PairModel> memory;
  const Refinement done = refine_window(window, kVgaCamera, 1, options, memory);
  EXPECT_TRUE(done.finished);
  EXPECT_GT(done.iterations, 2);
  EXPECT_LT(done.iterations, 50);
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
  const WindowOptions options{.depth_weight = 0};
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
                         testing::Values(WindowPairs::kNewest, WindowPairs::kOthers),
                         testing::PrintToStringParamName());

TEST(Window, AModelIsMovedWithSmallStepsAndMadeAnewAfterLargeOnes) {
  const WindowOptions options{.sigma = 6};  // residuals stay where the loss is quadratic
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

TEST(Window, AKeyframesViewIsNotSharedThroughAWall) {
  auto window = plane_window({SE3{}, motion(0.2, 0, 0, 0, 0, 0)}, {});
  window[1].half_depth *= 2;  // a surface halfway
  EXPECT_EQ(shared_view(window[0], window[1], kVgaCamera), 0);
}

TEST(Window, AKeyframesViewIsNotSharedFromTheOtherSideOfAWall) {
  const auto looking_at = [](double x, double z, double yaw) {  // [m], [rad]
    return motion(x, 0, z, 0, 0, 0) * motion(0, 0, 0, 0, yaw, 0);
  };
  const auto window = plane_window(
      {looking_at(0, 0, 0.85), looking_at(0.5, 0, 0.8), looking_at(-1.3, 3, 1.83)}, {});
  EXPECT_GT(shared_view(window[0], window[1], kVgaCamera), 0.5);
  EXPECT_LT(shared_view(window[0], window[2], kVgaCamera), 0.02);
}

}  // namespace
}  // namespace edvo
