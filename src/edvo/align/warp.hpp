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
struct Warp {
  std::array<float, 9> r;  // row-major
  std::array<float, 3> t;
  float fx, fy, cx, cy;
};

[[nodiscard]] inline Warp make_warp(const SE3& motion, const Camera& camera) {
  Warp warp{};
  const Eigen::Matrix3d R = motion.rotation.toRotationMatrix();
  for (int i = 0; i < 9; ++i)
    warp.r[static_cast<std::size_t>(i)] = static_cast<float>(R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i)
    warp.t[static_cast<std::size_t>(i)] = static_cast<float>(motion.translation[i]);
  warp.fx = static_cast<float>(camera.fx);
  warp.fy = static_cast<float>(camera.fy);
  warp.cx = static_cast<float>(camera.cx);
  warp.cy = static_cast<float>(camera.cy);
  return warp;
}

// About how far a motion of these lengths [m], [rad] moves points in the image [px].
[[nodiscard]] inline double pixels_moved(const Camera& camera, double translation,
                                         double rotation) {
  constexpr double kUsualDepth = 1.5;  // [m]
  return std::abs(camera.fx) * std::max(translation / kUsualDepth, rotation);
}

}  // namespace edvo
