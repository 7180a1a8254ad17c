// SPDX-License-Identifier: MIT
// Levenberg-Marquardt with gain-ratio damping (Madsen, Nielsen, Tingleff 2004, section 3.2).
#pragma once

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

// The length of a step and of all that would follow if each were as much shorter than the one
// before as this one is. Robust losses converge so, slowly where much does not fit: a short step
// alone does not tell that the end is near.
class StepsToCome {
 public:
  [[nodiscard]] double from(double step) const {
    const double rate = last_ > 0 ? std::min(step / last_, kSlowest) : 0.5;
    return step / (1 - rate);
  }
  void take(double step) { last_ = step; }

 private:
  static constexpr double kSlowest = 0.95;
  double last_ = 0;  // step taken, 0 = none
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
  StepsToCome to_come;
  while (summary.iterations < options.max_iterations) {
    auto damped = system.hessian;
    damped.diagonal() *= 1 + lambda;
    const Vector step = -damped.ldlt().solve(system.gradient);
    if (!step.allFinite()) return summary;
    const double size = problem.step_size(step);
    if (to_come.from(size) < options.step_tolerance) {
      summary.converged = true;
      return summary;
    }
    const X candidate = problem.update(x, step);
    const auto next = problem.linearize(candidate);
    ++summary.iterations;
    const double predicted = -(system.gradient.dot(step) + 0.5 * step.dot(system.hessian * step));
    const double gain = (system.cost - next.cost) / predicted;
    if (next.cost < system.cost && std::isfinite(next.cost)) {
      x = candidate;
      to_come.take(size);
      system = next;
      summary.cost = system.cost;
      lambda *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
      lambda = std::max(lambda, 1e-7);
      growth = 2;
    } else {
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
