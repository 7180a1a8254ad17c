// SPDX-License-Identifier: MIT
// A pair of keyframes of a window: what one's points, seen in the other, add to the normal
// equations, kept to second order while both move little.
#pragma once

#include "edvo/window/pair_linearization.hpp"

#include <vector>

namespace edvo {

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
  std::vector<PointNormals> point_normals;
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
