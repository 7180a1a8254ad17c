// SPDX-License-Identifier: MIT
// Figures of the report pages: a plot with its title, its caption and what the script must know.
#pragma once

#include "edvo/core/trajectory.hpp"
#include "edvo/report/plot.hpp"
#include "edvo/report/summary.hpp"

#include <string>
#include <vector>

namespace edvo {

inline constexpr const char* kTruthColor = "#8c8c8c";

struct Figure {
  std::string title, caption;
  std::string attributes;  // for the script
  Plot plot;
};

[[nodiscard]] std::string to_html(const Figure& figure);

// Two of the coordinates of the first camera (x right, y down, z ahead), one perhaps turned over.
struct View {
  const char* title;
  const char* x_label;
  const char* y_label;
  int right, up;   // which coordinate: 0 x, 1 y, 2 z
  double up_sign;  // y points down: shown upwards it is -y
};
inline constexpr View kTopView{"From above", "x, right [m]", "z, ahead [m]", 0, 2, 1};

// fy of the camera: negative where its y points up.
[[nodiscard]] const View& side_view(double fy);

// What all plots over time share.
struct Timeline {
  Stamp start;
  Limits range;                   // [s]
  std::vector<Limits> lost;       // [s]
  std::vector<double> keyframes;  // [s]
  std::vector<PlotEvent> events;
};

[[nodiscard]] Timeline make_timeline(const RunLog& log);

// The line of a trajectory, interrupted where tracking was lost.
[[nodiscard]] Series line_of(const Trajectory& trajectory, const View& view,
                             const Timeline& timeline, bool interrupted);

// A map without lines yet.
[[nodiscard]] Figure empty_map(const View& view, const std::string& caption);

// A plot over time without lines yet.
[[nodiscard]] Plot time_plot(const Timeline& timeline, std::string y_label);

// From zero to a little above what lines are drawn.
[[nodiscard]] Limits from_zero(const std::vector<Series>& series);

[[nodiscard]] Series series_of(const Curve& curve, const std::string& name,
                               const std::string& color, double scale = 1);

}  // namespace edvo
