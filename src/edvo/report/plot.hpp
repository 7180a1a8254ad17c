// SPDX-License-Identifier: MIT
// Line plots as SVG text: compact, no scripts, readable on a light and on a dark page.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace edvo {

// One line. A NaN or infinity in x or y interrupts it.
struct Series {
  std::string name;          // in the legend; shown when the plot has more than one series
  std::vector<double> x, y;  // same length
  std::string color = {};    // "#rrggbb"; empty = the next one of the palette
  double thickness = 1.6;    // [px]
};

struct Limits {
  double low = 0, high = 1;
};

// Something that happened at x, marked at the upper border.
struct PlotEvent {
  double x = 0;
  std::string text;   // what happened, shown by a browser under the mouse
  std::string color;  // "#rrggbb"
  std::string label;  // one or two letters; empty = a triangle
  std::string link;   // where a click leads, empty = nowhere
};

struct Plot {
  std::string title;
  std::string x_label, y_label;  // with the unit in brackets: "time [s]"
  std::vector<Series> series;
  bool equal_axes = false;  // one metre is as long along x as along y (maps)
  bool stacked = false;     // areas on top of each other; all x are the same
  std::optional<Limits> x_limits = {}, y_limits = {};  // otherwise from the data
  std::vector<Limits> bands = {};                      // spans of x to shade
  std::vector<double> marks = {};                      // x to tick along the lower border
  std::vector<PlotEvent> events = {};
  double width = 760, height = 0;  // [px]; height 0 = what suits the kind of plot
};

// A whole <svg> element, usable as a file and inside an HTML page. A script finds in its attribute
// data-area "left top width height [px] x_low x_high y_low y_high" of the axes, and in each path of
// class "series" the points of a line. Lines are thinned to what can be
// seen, so that a plot of any length stays a few ten kilobytes.
[[nodiscard]] std::string to_svg(const Plot& plot);

}  // namespace edvo
