// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {

constexpr float kNearest = 0.05F;  // [m] a point nearer to the camera is not in view

// A rigid motion and a projection as plain numbers.
struct View {
  std::array<float, 9> r;  // row-major
  std::array<float, 3> t;
  float fx, fy, cx, cy;
};

[[nodiscard]] inline View make_view(const SE3& motion, const Camera& camera) {
  View view{};
  const Eigen::Matrix3d R = motion.rotation.toRotationMatrix();
  for (int i = 0; i < 9; ++i)
    view.r[static_cast<std::size_t>(i)] = static_cast<float>(R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i)
    view.t[static_cast<std::size_t>(i)] = static_cast<float>(motion.translation[i]);
  view.fx = static_cast<float>(camera.fx);
  view.fy = static_cast<float>(camera.fy);
  view.cx = static_cast<float>(camera.cx);
  view.cy = static_cast<float>(camera.cy);
  return view;
}

// About how far a motion of these lengths [m], [rad] moves points in the image [px].
[[nodiscard]] inline double pixels_moved(const Camera& camera, double translation,
                                         double rotation) {
  constexpr double kUsualDepth = 1.5;  // [m]
  return std::abs(camera.fx) * std::max(translation / kUsualDepth, rotation);
}

}  // namespace edvo
