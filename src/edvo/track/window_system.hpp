// SPDX-License-Identifier: MIT
// The normal equations of a window of keyframes, inverse depths eliminated.
#pragma once

#include "edvo/track/window_pair.hpp"

#include <Eigen/Core>

namespace edvo {

struct WindowSystem {
  Eigen::MatrixXd hessian;  // of the free keyframes, depths eliminated
  Eigen::VectorXd gradient;
  double cost = 0;
  // Host after host, point after point.
  std::vector<DepthSystem> depths;
  std::vector<float> coupling;  // (points) x (unknowns), d^2 cost / d inverse depth d unknowns
};

// The first `fixed` keyframes have no unknowns but the inverse depths of their points.
[[nodiscard]] WindowSystem linearize_window(const std::vector<WindowKeyframe>& window,
                                            const Camera& camera, int fixed,
                                            const WindowOptions& options);

// Moves poses, brightness and inverse depths by the solution of the system.
void apply_step(const WindowSystem& system, const Eigen::VectorXd& step, int fixed,
                std::vector<WindowKeyframe>& window);

}  // namespace edvo
