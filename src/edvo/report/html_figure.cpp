// SPDX-License-Identifier: MIT
#include "edvo/report/html_figure.hpp"

#include "edvo/report/html_events.hpp"
#include "edvo/report/markup.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace edvo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double kPlotWidth = 580;   // [px]
constexpr double kPlotHeight = 290;  // [px]
constexpr double kMapHeight = 430;   // [px]

constexpr View kSideView{"From the side", "z, ahead [m]", "-y, up [m]", 2, 1, -1};
// Of a camera with negative fy: its y points up.
constexpr View kSideViewOfUpwardY{"From the side", "z, ahead [m]", "y, up [m]", 2, 1, 1};

}  // namespace

std::string to_html(const Figure& figure) {
  return fmt::format(
      "<figure class=\"card\" style=\"margin:0\" {}><h2>{}</h2><p class=\"soft\">{}</p>{}"
      "</figure>\n",
      figure.attributes, escape_markup(figure.title), escape_markup(figure.caption),
      to_svg(figure.plot));
}

const View& side_view(double fy) {
  return fy < 0 ? kSideViewOfUpwardY : kSideView;
}

Timeline make_timeline(const RunLog& log) {
  Timeline timeline;
  if (log.frames.empty()) return timeline;
  timeline.start = log.frames.front().stamp;
  timeline.range.high = std::max(1e-3, seconds_between(timeline.start, log.frames.back().stamp));
  bool was_lost = false;
  for (const FrameRecord& frame : log.frames) {
    const double seconds = seconds_between(timeline.start, frame.stamp);
    const bool is_lost = frame.status == FrameStatus::kLost;
    if (is_lost && !was_lost) timeline.lost.push_back({seconds, seconds});
    if (was_lost) timeline.lost.back().high = seconds;
    if (frame.keyframe) timeline.keyframes.push_back(seconds);
    was_lost = is_lost;
  }
  timeline.events = plot_events_of(log);
  return timeline;
}

Series line_of(const Trajectory& trajectory, const View& view, const Timeline& timeline,
               bool interrupted) {
  Series series;
  std::size_t gap = 0;
  for (const StampedPose& pose : trajectory) {
    const double seconds = seconds_between(timeline.start, pose.stamp);
    bool in_gap = false;
    for (; gap < timeline.lost.size() && timeline.lost[gap].low < seconds; ++gap) in_gap = true;
    if (in_gap && interrupted) {
      series.x.push_back(kNaN);
      series.y.push_back(kNaN);
    }
    const Eigen::Vector3d& position = pose.world_from_camera.translation;
    series.x.push_back(position[view.right]);
    series.y.push_back(view.up_sign * position[view.up]);
  }
  return series;
}

Figure empty_map(const View& view, const std::string& caption) {
  return {.title = view.title,
          .caption = caption,
          .attributes = fmt::format("data-kind=\"map\" data-right=\"{}\" data-up=\"{}\" "
                                    "data-sign=\"{}\"",
                                    view.right, view.up, view.up_sign),
          .plot = {.x_label = view.x_label,
                   .y_label = view.y_label,
                   .equal_axes = true,
                   .width = kPlotWidth,
                   .height = kMapHeight}};
}

Plot time_plot(const Timeline& timeline, std::string y_label) {
  return {.x_label = "time [s]",
          .y_label = std::move(y_label),
          .x_limits = timeline.range,
          .bands = timeline.lost,
          .events = timeline.events,
          .width = kPlotWidth,
          .height = kPlotHeight};
}

// From zero to a little above what lines are drawn.
Limits from_zero(const std::vector<Series>& series) {
  double highest = 0;
  for (const Series& line : series)
    for (const double y : line.y)
      if (std::isfinite(y)) highest = std::max(highest, y);
  return {0, highest > 0 ? 1.06 * highest : 1.0};
}

Series series_of(const Curve& curve, const std::string& name, const std::string& color,
                 double scale) {
  Series series{.name = name, .x = curve.seconds, .y = curve.values, .color = color};
  for (double& y : series.y) y *= scale;
  return series;
}

}  // namespace edvo
