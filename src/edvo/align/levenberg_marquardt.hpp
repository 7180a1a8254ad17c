// SPDX-License-Identifier: MIT
// Levenberg-Marquardt with gain-ratio damping (Madsen, Nielsen, Tingleff 2004, section 3.2).
#pragma once

#include "edvo/align/aitken.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <concepts>

namespace edvo {

// Gauss-Newton approximation of a cost: cost(x + d) ~ cost + gradient' d + 0.5 d' hessian d.
template <int N>
struct LinearSystem {
  Eigen::Matrix<double, N, N> hessian = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> gradient = Eigen::Matrix<double, N, 1>::Zero();
  double cost = 0;
};

struct MinimizeOptions {
  int max_iterations = 30;
  double initial_lambda = 1e-3;  // relative to the diagonal of the Hessian
  double step_tolerance = 1e-5;  // of all steps still to come, see Problem::step_size
};

// How many steps lead to the end, which is how far it is: a short step alone does not tell. And the
// step itself may be longer.
template <typename Vector>
class StepsToCome {
 public:
  // All of them together, in steps. metric: the Hessian, in which unknowns of all units compare.
  template <typename Matrix>
  [[nodiscard]] double count(const Vector& step, const Matrix& metric) const {
    if (taken_ == 0) return kUnknown;
    const Vector scaled = metric * last_;
    const Vector this_scaled = metric * step;
    return steps_to_come(taken_, scaled.dot(last_), scaled.dot(step), this_scaled.dot(step));
  }
  // How many times to take one for which there are so many.
  [[nodiscard]] double at_once(double count) const {
    return taken_ == 0 ? 1.0 : steps_at_once(count);
  }
  void take(const Vector& step, double times) {
    last_ = step;
    taken_ = times;
  }
  void forget() { taken_ = 0; }

 private:
  static constexpr double kUnknown = 2;
  Vector last_ = Vector::Zero();
  double taken_ = 0;  // times, 0 = none yet
};

struct MinimizeSummary {
  int iterations = 0;  // linearizations
  double cost = 0;     // at the result
  bool converged = false;
};

template <typename P, typename X>
concept LeastSquaresProblem = requires(const P& problem, const X& x) {
  { problem.linearize(x).cost } -> std::convertible_to<double>;
  { problem.update(x, problem.linearize(x).gradient) } -> std::same_as<X>;
  { problem.step_size(problem.linearize(x).gradient) } -> std::convertible_to<double>;
};

// Lowers the cost from x. A rejected step leaves no trace in x or in the linear system.
template <typename X, typename Problem>
requires LeastSquaresProblem<Problem, X> MinimizeSummary minimize(const Problem& problem, X& x,
                                                                  const MinimizeOptions& options) {
  auto system = problem.linearize(x);
  MinimizeSummary summary{.iterations = 1, .cost = system.cost, .converged = false};
  using Vector = decltype(system.gradient);
  double lambda = options.initial_lambda, growth = 2;
  StepsToCome<Vector> to_come;
  while (summary.iterations < options.max_iterations) {
    auto damped = system.hessian;
    damped.diagonal() *= 1 + lambda;
    const Vector step = -damped.ldlt().solve(system.gradient);
    if (!step.allFinite()) return summary;
    const double count = to_come.count(step, system.hessian);
    if (count * problem.step_size(step) < options.step_tolerance) {
      summary.converged = true;
      return summary;
    }
    const double times = to_come.at_once(count);
    const Vector long_step = times * step;
    const X candidate = problem.update(x, long_step);
    const auto next = problem.linearize(candidate);
    ++summary.iterations;
    const double predicted =
        -(system.gradient.dot(long_step) + 0.5 * long_step.dot(system.hessian * long_step));
    const double gain = (system.cost - next.cost) / predicted;
    if (next.cost < system.cost && std::isfinite(next.cost)) {
      x = candidate;
      to_come.take(step, times);
      system = next;
      summary.cost = system.cost;
      lambda *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
      lambda = std::max(lambda, 1e-7);
      growth = 2;
    } else {
      to_come.forget();
      lambda *= growth;
      growth *= 2;
      if (lambda > 1e7) {
        summary.converged = true;  // no descent in any direction: as low as the numbers allow
        return summary;
      }
    }
  }
  return summary;
}

}  // namespace edvo
