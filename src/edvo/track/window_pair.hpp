// SPDX-License-Identifier: MIT
// What one keyframe's points, seen in another, add to the normal equations of a window.
#pragma once

#include "edvo/track/window.hpp"

#include <array>
#include <vector>

namespace edvo {

constexpr int kKeyframeUnknowns = 8;      // xi, gain, bias / kBrightnessUnit
constexpr double kBrightnessUnit = 64.0;  // [grey levels] makes gain and bias steps of like size

// Own part of the unknown inverse depth of a point.
struct DepthSystem {
  float gradient = 0;
  float curvature = 0;
};

struct PairGeometry {
  std::array<float, 9> rotation;  // row-major, target from host
  std::array<float, 3> translation;
  Matrix6d adjoint;
  float gain, bias_host, bias_target;
  float inverse_host_gain;
};

// What does not change during a linearization.
struct PairConstants {
  float fx, fy, cx, cy, limit_u, limit_v;
  float sigma, own_sigma, huber, most;
  float geometric, depth_variance, depth_bias;
};

// What a pair of keyframes adds; unknowns are the relative twist (moving host points), the gain and
// the bias of the target. The host's own act through the same columns.
struct PairSums {
  std::array<float, kKeyframeUnknowns * kKeyframeUnknowns> hessian{};  // row-major
  std::array<float, kKeyframeUnknowns> gradient{};
};

[[nodiscard]] PairGeometry pair_geometry(const WindowKeyframe& host, const WindowKeyframe& target);

// own_sigma is for update_pair.
[[nodiscard]] PairConstants pair_constants(const Camera& camera, const WindowOptions& options);

// Adds all points of a host as seen in a target. coupling: (points) x kKeyframeUnknowns of this
// pair, zero where a point is not seen. Returns the cost.
[[nodiscard]] double add_pair(const PairConstants& c, const PairGeometry& g,
                              const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                              PairSums& pair, DepthSystem* depths, float* coupling);

// What a host's points seen in a target add, to second order about a state of both.
struct PairModel {
  Stamp host, target;
  SE3 linearized_at;          // target from host
  PairGeometry geometry;      // there, as are the unknowns below
  SE3 target_from_host;       // the state now
  double gain = 1;            // I = gain * I_host + offset
  double offset = 0;          // [grey levels]
  float sigma = 0;            // of the photometric residuals, found at the first linearization
  std::vector<float> depths;  // of the host's points, inverse [1 / m]
  double cost = 0;
  PairSums sums;
  std::vector<DepthSystem> depth_systems;
  std::vector<float> coupling;  // (points) x kKeyframeUnknowns
};

// Makes the model one of the present state: moves it there, or linearizes anew if it is none yet or
// if points have moved by `limit` since [px]. Points in view, inliers and weights stay as they were
// linearized.
void update_pair(const PairConstants& c, const WindowKeyframe& host, const WindowKeyframe& target,
                 double limit, PairModel& model);

// Appends the depth residuals of some of a host's points in a target [sigmas].
void append_depth_errors(const PairConstants& c, const PairGeometry& g,
                         const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                         std::vector<float>& errors);

}  // namespace edvo
