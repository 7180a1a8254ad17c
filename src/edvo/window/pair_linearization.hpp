// SPDX-License-Identifier: MIT
// What one keyframe's points, seen in another, add to the normal equations of a window.
#pragma once

#include "edvo/align/brightness.hpp"
#include "edvo/align/warp.hpp"
#include "edvo/window/window_keyframe.hpp"

#include <array>
#include <vector>

namespace edvo {

constexpr float kLeastScale = 0.05F;  // of a point's depth in the target by that in the host
constexpr float kMargin = 3.F;        // [px] room that a patch needs
constexpr int kKeyframeUnknowns = 8;  // xi, gain, bias / kBrightnessUnit

// Own part of the unknown inverse depth of a point.
struct PointNormals {
  float gradient = 0;
  float curvature = 0;
};

struct PairGeometry {
  RigidMotion target_from_host;
  Matrix6d adjoint;
  float gain, bias_host, bias_target;
  float inverse_host_gain;
  RowMotion host_rows, target_rows;
};

// What does not change during a linearization.
struct PairConstants {
  Pinhole camera;
  float limit_u, limit_v;
  float sigma, pair_sigma_scale, huber, most;
  float depth_weight, depth_variance, depth_bias;
};

// What a pair of keyframes adds; unknowns are the relative twist (moving host points), the gain and
// the bias of the target. The host's own act through the same columns.
struct PairSums {
  std::array<float, kKeyframeUnknowns * kKeyframeUnknowns> hessian{};  // row-major
  std::array<float, kKeyframeUnknowns> gradient{};
};

[[nodiscard]] PairGeometry pair_geometry(const WindowKeyframe& host, const WindowKeyframe& target);

// pair_sigma_scale is for update_pair.
[[nodiscard]] PairConstants pair_constants(const Camera& camera, const WindowOptions& options);

// Adds all points of a host as seen in a target. coupling: (points) x kKeyframeUnknowns of this
// pair, zero where a point is not seen. Returns the cost.
[[nodiscard]] double add_pair(const PairConstants& c, const PairGeometry& g,
                              const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                              PairSums& pair, PointNormals* depths, float* coupling);

}  // namespace edvo
