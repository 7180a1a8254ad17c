// SPDX-License-Identifier: MIT
// The cost of a window of keyframes to second order.
#pragma once

#include "edvo/track/window_pair.hpp"

#include <Eigen/Core>

namespace edvo {

// About one state of the window: of the free keyframes' poses and brightness, and of all points'
// inverse depths, host after host, point after point.
struct WindowSystem {
  Eigen::MatrixXd hessian;  // n x n, of the keyframes
  Eigen::VectorXd gradient;
  double cost = 0;
  std::vector<DepthSystem> depths;
  std::vector<float> coupling;  // (points) x n, d^2 cost / d inverse depth d keyframes
};

struct WindowStep {
  Eigen::VectorXd keyframes;
  std::vector<float> depths;
};

// Pairs of keyframes between which residuals are taken: those with the newest, or all others.
enum class WindowPairs { kNewest, kOthers };

// The first `fixed` keyframes have no unknowns but the inverse depths of their points. Priors are
// counted with the others.
[[nodiscard]] WindowSystem linearize_window(const std::vector<WindowKeyframe>& window,
                                            const Camera& camera, int fixed, WindowPairs pairs,
                                            const WindowOptions& options);

// Lowest point of the sum of two, the inverse depths eliminated; the diagonal grown by lambda.
[[nodiscard]] WindowStep solve(const WindowSystem& a, const WindowSystem& b, double lambda);

// Moves poses, brightness and inverse depths. The step's are cut to what was moved.
void apply_step(WindowStep& step, int fixed, std::vector<WindowKeyframe>& window);

// The same second-order cost about the state a step away.
void move_by(const WindowStep& step, WindowSystem& system);

}  // namespace edvo
