// SPDX-License-Identifier: MIT
// The joint refinement of a window, in parts that frames can share.
#pragma once

#include "edvo/window/window_system.hpp"

namespace edvo {

// How far to go along each step. Products are in the metric of the keyframes' Hessian:
// H step = -gradient.
class Relaxation {
 public:
  [[nodiscard]] double next(const WindowStep& step);

 private:
  double factor_ = 1, last_own_ = 0;
  Eigen::VectorXd last_;
};

// A refinement under way: the cost about the present state of a window.
struct Refinement {
  Camera camera;
  int fixed = 1;
  WindowOptions options;        // depth noise as this window shows it
  WindowSystem others, newest;  // pairs of keyframes without and with the newest
  Relaxation relaxation;
  int iterations = 0;  // linearizations so far
  double first_cost = 0, cost = 0;
  bool finished = true;  // the options' number is reached, or a step gained too little
};

// Linearizes the joint cost over poses, brightness and inverse depths of all but the first `fixed`
// keyframes. memory: models of pairs, those of the last refinement of most of these keyframes and
// then of this; empty at first. Keyframes are told apart by their stamps.
[[nodiscard]] Refinement begin_refinement(const std::vector<WindowKeyframe>& window,
                                          const Camera& camera, int fixed,
                                          const WindowOptions& options,
                                          std::vector<PairModel>& memory);

// Lowers that cost by at most so many steps. window, memory: as they were left.
void advance(Refinement& refinement, std::vector<WindowKeyframe>& window, int steps,
             std::vector<PairModel>& memory);

// Both, to the end.
Refinement refine_window(std::vector<WindowKeyframe>& window, const Camera& camera, int fixed,
                         const WindowOptions& options, std::vector<PairModel>& memory);

}  // namespace edvo
