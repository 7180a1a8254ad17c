// SPDX-License-Identifier: MIT
// The unknowns of a keyframe, and how those of a pair of keyframes depend on them.
#pragma once

#include "edvo/window/pair_linearization.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace edvo {

using BlockMatrix = Eigen::Matrix<double, kKeyframeUnknowns, kKeyframeUnknowns>;
using BlockVector = Eigen::Matrix<double, kKeyframeUnknowns, 1>;

// Of the target: the diagonal.
constexpr std::array<float, kKeyframeUnknowns> kFromTarget = {-1, -1, -1, -1, -1, -1, 1, 1};

// Pair unknowns from the unknowns of the host.
[[nodiscard]] inline BlockMatrix from_host(const PairGeometry& g) {
  BlockMatrix A = BlockMatrix::Zero();
  A.topLeftCorner<6, 6>() = g.adjoint;
  A(6, 6) = A(7, 7) = -static_cast<double>(g.gain);
  return A;
}

inline void move_keyframe(const BlockVector& step, WindowKeyframe& key) {
  const Vector6d xi = step.head<6>();
  key.world_from_key = key.world_from_key * exp(xi);
  key.gain += step[6];
  key.bias += kBrightnessUnit * step[7];
}

// Returns what was moved: the sensor is never wrong by a factor of two; a step that says so comes
// from a wrong match.
inline double move_point(double step, WindowPoint& point) {
  const double moved =
      std::clamp(point.inverse_depth + step, 0.5 * point.measured, 2 * point.measured);
  return moved - std::exchange(point.inverse_depth, moved);
}

// What a step changes of a window, to undo one.
struct Estimates {
  struct Keyframe {
    SE3 world_from_key;
    double gain, bias;
  };
  std::vector<Keyframe> keyframes;
  std::vector<double> inverse_depths;
};

[[nodiscard]] Estimates estimates_of(const std::vector<WindowKeyframe>& window);
void restore(const Estimates& all, std::vector<WindowKeyframe>& window);

}  // namespace edvo
