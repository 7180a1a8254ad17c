// SPDX-License-Identifier: MIT
// The cost of a window of keyframes to second order.
#pragma once

#include "edvo/window/pair_model.hpp"

#include <Eigen/Core>

namespace edvo {

// Of one host's points' inverse depths with those keyframes that any of them couples with.
struct PosePointBlocks {
  std::size_t points = 0;
  std::vector<int> columns;   // first ones of the keyframes' blocks in the Hessian, ascending
  std::vector<float> values;  // (points) x (blocks) x kKeyframeUnknowns
};

// About one state of the window: of the free keyframes' poses and brightness, and of all points'
// inverse depths, host after host, point after point.
struct WindowSystem {
  Eigen::MatrixXd hessian;  // n x n, of the keyframes
  Eigen::VectorXd gradient;
  double cost = 0;
  std::vector<PointNormals> depths;
  std::vector<PosePointBlocks> couplings;  // of each host, d^2 cost / d inverse depth d keyframes
};

struct WindowStep {
  Eigen::VectorXd keyframes;
  std::vector<float> depths;
  Eigen::VectorXd gradient;  // of the cost by the keyframes, each inverse depth at its best
};

// Pairs of keyframes between which residuals are taken: those with the newest, or all others.
enum class WindowPairs { kNewest, kOthers };

// The first `fixed` keyframes have no unknowns but the inverse depths of their points. Priors are
// counted with the others. models: of all pairs, host by host, the targets of each; made to tell of
// the present state where they are used.
[[nodiscard]] WindowSystem linearize_window(const std::vector<WindowKeyframe>& window,
                                            const Camera& camera, int fixed, WindowPairs pairs,
                                            const WindowOptions& options,
                                            std::vector<PairModel>& models);

// Lowest point of the sum of two, the inverse depths eliminated; the diagonal grown by lambda.
[[nodiscard]] WindowStep solve(const WindowSystem& a, const WindowSystem& b, double lambda);

// Moves poses, brightness and inverse depths. The step's are cut to what was moved.
void apply_step(WindowStep& step, int fixed, std::vector<WindowKeyframe>& window);

// The same second-order cost about the state a step away.
void move_by(const WindowStep& step, WindowSystem& system);

}  // namespace edvo
