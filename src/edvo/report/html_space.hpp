// SPDX-License-Identifier: MIT
// Trajectories in space, to turn with the mouse.
#pragma once

#include "edvo/report/html_figure.hpp"

#include <string>
#include <vector>

namespace edvo {

struct SpaceLine {
  std::string name, color;
  Trajectory trajectory;
  const Timeline* interrupted_by = nullptr;  // where tracking was lost; null = nowhere
  bool is_dots = false;
};

// A card with the picture of the lines from a fixed point of view. With scripts, kSpaceScript puts
// a view in its place that turns. up_sign: -1 where y points down. Empty without any pose.
[[nodiscard]] std::string space_card(const std::vector<SpaceLine>& lines, double up_sign,
                                     const std::string& caption);

}  // namespace edvo
