// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {

constexpr float kNearest = 0.05F;  // [m] a point nearer to the camera is not in view

// The warp of direct alignment as plain numbers, for loops over many points: frames move
// points in space, keyframes of a window rays with an inverse depth.
struct RigidMotion {
  std::array<float, 9> r;  // row-major
  std::array<float, 3> t;  // [m]
};

struct Pinhole {
  float fx, fy, cx, cy;  // [px]
};

struct Warp {
  RigidMotion motion;
  Pinhole camera;
};

[[nodiscard]] inline RigidMotion rigid_motion(const SE3& motion) {
  RigidMotion plain{};
  const Eigen::Matrix3d R = motion.rotation.toRotationMatrix();
  for (int i = 0; i < 9; ++i)
    plain.r[static_cast<std::size_t>(i)] = static_cast<float>(R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i)
    plain.t[static_cast<std::size_t>(i)] = static_cast<float>(motion.translation[i]);
  return plain;
}

[[nodiscard]] inline Pinhole pinhole(const Camera& camera) {
  return {.fx = static_cast<float>(camera.fx),
          .fy = static_cast<float>(camera.fy),
          .cx = static_cast<float>(camera.cx),
          .cy = static_cast<float>(camera.cy)};
}

[[nodiscard]] inline Warp make_warp(const SE3& motion, const Camera& camera) {
  return {.motion = rigid_motion(motion), .camera = pinhole(camera)};
}

// About how far a motion of these lengths [m], [rad] moves points in the image [px].
[[nodiscard]] inline double pixels_moved(const Camera& camera, double translation,
                                         double rotation) {
  constexpr double kUsualDepth = 1.5;  // [m]
  return std::abs(camera.fx) * std::max(translation / kUsualDepth, rotation);
}

}  // namespace edvo
