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

// A rolling shutter: how the camera moves while the rows of an image are read
// (RollingShutter::readout).
struct RowMotion {
  std::array<float, 3> rho, phi;  // [m], [rad] from the first row to the last
  float per_row;                  // 1 / rows
  bool is_none;
};

// Moves a point by the camera's motion in a share of the readout. A point may be given times an
// inverse depth.
template <typename Value>
[[gnu::always_inline]] inline void move_by_share(const RowMotion& m, const Value& share, Value& x,
                                                 Value& y, Value& z, const Value& inverse_depth) {
  const Value dx = m.phi[1] * z - m.phi[2] * y + m.rho[0] * inverse_depth;
  const Value dy = m.phi[2] * x - m.phi[0] * z + m.rho[1] * inverse_depth;
  const Value dz = m.phi[0] * y - m.phi[1] * x + m.rho[2] * inverse_depth;
  x += share * dx;
  y += share * dy;
  z += share * dz;
}

// From the camera as it is when it reads that row to the camera as it is at the middle one.
template <typename Value>
[[gnu::always_inline]] inline void move_to_middle_row(const RowMotion& m, const Value& row,
                                                      Value& x, Value& y, Value& z,
                                                      const Value& inverse_depth) {
  move_by_share<Value>(m, row * m.per_row - 0.5F, x, y, z, inverse_depth);
}

// And back.
template <typename Value>
[[gnu::always_inline]] inline void move_from_middle_row(const RowMotion& m, const Value& row,
                                                        Value& x, Value& y, Value& z,
                                                        const Value& inverse_depth) {
  move_by_share<Value>(m, 0.5F - row * m.per_row, x, y, z, inverse_depth);
}

struct Warp {
  RigidMotion motion;
  Pinhole camera;
  RowMotion rows;  // of the frame that points are moved to
};

[[nodiscard]] inline RowMotion row_motion(const Vector6d& readout, int height) {
  RowMotion rows{};
  for (int i = 0; i < 3; ++i) {
    rows.rho[static_cast<std::size_t>(i)] = static_cast<float>(readout[i]);
    rows.phi[static_cast<std::size_t>(i)] = static_cast<float>(readout[3 + i]);
  }
  rows.per_row = 1.F / static_cast<float>(height);
  rows.is_none = readout.isZero(0);
  return rows;
}

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

[[nodiscard]] inline Warp make_warp(const SE3& motion, const Camera& camera,
                                    const Vector6d& readout) {
  return {.motion = rigid_motion(motion),
          .camera = pinhole(camera),
          .rows = row_motion(readout, camera.height)};
}

// About how far a motion of these lengths [m], [rad] moves points in the image [px].
[[nodiscard]] inline double pixels_moved(const Camera& camera, double translation,
                                         double rotation) {
  constexpr double kUsualDepth = 1.5;  // [m]
  return std::abs(camera.fx) * std::max(translation / kUsualDepth, rotation);
}

}  // namespace edvo
