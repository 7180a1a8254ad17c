// SPDX-License-Identifier: MIT
// Marks of events in a plot over time.
#pragma once

#include "edvo/report/plot.hpp"

#include <string>
#include <vector>

namespace edvo {

// Where the axes of a plot are, and the x at its left and right border.
struct PlotArea {
  double left = 0, top = 0, width = 0, height = 0;  // [px]
  Limits x;
};

// A line through the plot for each event, with a triangle or its label at the upper border. Events
// of one colour that are too close to be told apart share a mark; its text names them.
[[nodiscard]] std::string event_marks(const std::vector<PlotEvent>& events, const PlotArea& area);

}  // namespace edvo
