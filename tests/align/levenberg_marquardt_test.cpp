// SPDX-License-Identifier: MIT
#include "edvo/align/levenberg_marquardt.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace edvo {
namespace {

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

using Number = Eigen::Matrix<double, 1, 1>;

TEST(StepsToCome, AreKnownFromTwoStepsWhereEachIsAsMuchShorter) {
  StepsToCome<Number> to_come;
  to_come.take(Number(1.0), 1);
  EXPECT_DOUBLE_EQ(to_come.count(Number(0.75), Number(7.0)), 4.0);  // 1 + 0.75 + 0.75^2 + ...
  EXPECT_LT(to_come.at_once(4.0), 2.0);
  // Taken 1.6 times, which left 1 - 0.25 x 1.6 = 0.6 of the error.
  to_come.take(Number(0.75), 1.6);
  EXPECT_NEAR(to_come.count(Number(0.45), Number(7.0)), 4.0, 1e-12);
}

TEST(StepsToCome, AreFiniteWhereStepsGrowAndAtLeastThisOne) {
  StepsToCome<Number> to_come;
  EXPECT_EQ(to_come.at_once(to_come.count(Number(1.0), Number(1.0))), 1.0);  // nothing is known yet
  to_come.take(Number(1.0), 1);
  EXPECT_EQ(to_come.count(Number(2.0), Number(1.0)), 20.0);
  EXPECT_EQ(to_come.count(Number(-0.5), Number(1.0)), 1.0);
  to_come.forget();
  EXPECT_EQ(to_come.at_once(9.0), 1.0);
}

// x^2 / 2 by Newton's steps whose curvature is ten times the true one, as the weights of a robust
// loss make it: every step goes a tenth of the way.
struct Slow {
  static LinearSystem<1> linearize(double x) {
    LinearSystem<1> system;
    system.hessian(0, 0) = 10;
    system.gradient[0] = x;
    system.cost = 0.5 * x * x;
    return system;
  }
  static double update(double x, const Eigen::Matrix<double, 1, 1>& step) { return x + step[0]; }
  static double step_size(const Eigen::Matrix<double, 1, 1>& step) { return std::abs(step[0]); }
};

TEST(LevenbergMarquardt, IsNotContentWithShortStepsFarFromTheEnd) {
  double x = 1;
  const MinimizeSummary summary =
      minimize(Slow{}, x, {.max_iterations = 1000, .step_tolerance = 0.02});
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(std::abs(x), 0.025);  // the step alone is that short at 0.2
}

}  // namespace
}  // namespace edvo
