// SPDX-License-Identifier: MIT
// Line plots as SVG text: compact, no scripts, readable on a light and on a dark page.
#pragma once

#include <string>
#include <vector>

namespace edvo {

// One line. A NaN or infinity in x or y interrupts it.
struct Series {
  std::string name;          // in the legend; shown when the plot has more than one series
  std::vector<double> x, y;  // same length
  std::string color = {};    // "#rrggbb"; empty = the next one of the palette
};

struct Plot {
  std::string title;
  std::string x_label, y_label;  // with the unit in brackets: "time [s]"
  std::vector<Series> series;
  bool equal_axes = false;  // one metre is as long along x as along y (maps)
};

// A whole <svg> element, usable as a file and inside an HTML page. Lines are thinned to what can be
// seen, so that a plot of any length stays a few ten kilobytes.
[[nodiscard]] std::string to_svg(const Plot& plot);

}  // namespace edvo
