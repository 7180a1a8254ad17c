// SPDX-License-Identifier: MIT
// Small trajectories for the tests of the evaluation.
#pragma once

#include "edvo/core/trajectory.hpp"

#include <cmath>

namespace edvo::test {

inline constexpr std::int64_t kMillisecond = 1'000'000;  // [ns]

[[nodiscard]] inline Stamp stamp_at(std::int64_t milliseconds) {
  return {.nanoseconds = milliseconds * kMillisecond, .decimals = 3};
}

// Along x at 1 m/s, a pose each step.
[[nodiscard]] inline Trajectory straight_path(int poses, std::int64_t step = 100 /* [ms] */) {
  Trajectory path;
  for (int i = 0; i < poses; ++i) {
    StampedPose pose{.stamp = stamp_at(i * step), .world_from_camera = {}};
    pose.world_from_camera.translation.x() = 1e-3 * static_cast<double>(i * step);
    path.push_back(pose);
  }
  return path;
}

// A curve through all three directions while the camera turns.
[[nodiscard]] inline Trajectory winding_path(int poses) {
  Trajectory path;
  for (int i = 0; i < poses; ++i) {
    const double t = 0.1 * i;  // [s]
    Vector6d xi;
    xi << std::cos(t), 2 * std::sin(t), 0.5 * std::sin(2 * t), 0.3 * t, -0.1 * t, 0.2 * std::sin(t);
    path.push_back({.stamp = stamp_at(100 * i), .world_from_camera = exp(xi)});
  }
  return path;
}

[[nodiscard]] inline Trajectory moved(const SE3& motion, Trajectory path) {
  for (StampedPose& pose : path) pose.world_from_camera = motion * pose.world_from_camera;
  return path;
}

[[nodiscard]] inline Trajectory stretched(double scale, Trajectory path) {
  for (StampedPose& pose : path) pose.world_from_camera.translation *= scale;
  return path;
}

}  // namespace edvo::test
