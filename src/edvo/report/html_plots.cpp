// SPDX-License-Identifier: MIT
#include "edvo/report/html_plots.hpp"

#include "edvo/report/html_events.hpp"
#include "edvo/report/markup.hpp"
#include "edvo/report/plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr double kPlotWidth = 580;   // [px]
constexpr double kPlotHeight = 290;  // [px]
constexpr double kMapHeight = 430;   // [px]
constexpr std::size_t kMostRoutePoints = 1500;
constexpr std::size_t kMostBars = 1000;  // columns of the plot of times

constexpr const char* kTruthColor = "#8c8c8c";
constexpr const char* kFinalColor = "#0072b2";
constexpr const char* kOnlineColor = "#e69f00";
constexpr const char* kKeyframeColor = "#d55e00";

// What all plots over time share.
struct Timeline {
  Stamp start;
  Limits range;                   // [s]
  std::vector<Limits> lost;       // [s]
  std::vector<double> keyframes;  // [s]
  std::vector<PlotEvent> events;
};

double seconds_since_start(const RunLog& log, const Stamp& stamp) {
  return seconds_between(log.frames.front().stamp, stamp);
}

Timeline make_timeline(const RunLog& log) {
  Timeline timeline;
  if (log.frames.empty()) return timeline;
  timeline.start = log.frames.front().stamp;
  timeline.range.high = std::max(1e-3, seconds_since_start(log, log.frames.back().stamp));
  bool was_lost = false;
  for (const FrameRecord& frame : log.frames) {
    const double seconds = seconds_since_start(log, frame.stamp);
    const bool is_lost = frame.status == FrameStatus::kLost;
    if (is_lost && !was_lost) timeline.lost.push_back({seconds, seconds});
    if (was_lost) timeline.lost.back().high = seconds;
    if (frame.keyframe) timeline.keyframes.push_back(seconds);
    was_lost = is_lost;
  }
  timeline.events = plot_events_of(log);
  return timeline;
}

// Two of the coordinates of the first camera (x right, y down, z ahead), one perhaps turned over.
struct View {
  const char* title;
  const char* x_label;
  const char* y_label;
  int right, up;   // which coordinate: 0 x, 1 y, 2 z
  double up_sign;  // y points down: shown upwards it is -y
};
constexpr View kTopView{"From above", "x, right [m]", "z, ahead [m]", 0, 2, 1};
constexpr View kSideView{"From the side", "z, ahead [m]", "-y, up [m]", 2, 1, -1};
// Of a camera with negative fy: its y points up.
constexpr View kSideViewOfUpwardY{"From the side", "z, ahead [m]", "y, up [m]", 2, 1, 1};

// The line of a trajectory, interrupted where tracking was lost.
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

Series dots_of(const Trajectory& trajectory, const View& view) {
  Series series;
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& position = pose.world_from_camera.translation;
    series.x.insert(series.x.end(), {position[view.right], kNaN});
    series.y.insert(series.y.end(), {view.up_sign * position[view.up], kNaN});
  }
  return series;
}

struct Figure {
  std::string title, caption;
  std::string attributes;  // for the script
  Plot plot;
};

std::string to_html(const Figure& figure) {
  return fmt::format(
      "<figure class=\"card\" style=\"margin:0\" {}><h2>{}</h2><p class=\"soft\">{}</p>{}"
      "</figure>\n",
      figure.attributes, escape_markup(figure.title), escape_markup(figure.caption),
      to_svg(figure.plot));
}

Figure map_figure(const View& view, const RunSummary& summary, const RunOutcome& outcome,
                  const Timeline& timeline) {
  Plot plot{.x_label = view.x_label,
            .y_label = view.y_label,
            .equal_axes = true,
            .width = kPlotWidth,
            .height = kMapHeight};
  const auto add = [&](Series series, const char* name, const char* color, double thickness) {
    series.name = name;
    series.color = color;
    series.thickness = thickness;
    plot.series.push_back(std::move(series));
  };
  if (summary.evaluation)
    add(line_of(summary.evaluation->truth, view, timeline, false), "ground truth", kTruthColor,
        2.2);
  add(line_of(outcome.trajectory, view, timeline, true), "estimate", kFinalColor, 1.6);
  add(dots_of(outcome.keyframes, view), "keyframes", kKeyframeColor, 4);
  return {.title = view.title,
          .caption = "In the frame of the first camera.",
          .attributes = fmt::format("data-kind=\"map\" data-right=\"{}\" data-up=\"{}\" "
                                    "data-sign=\"{}\"",
                                    view.right, view.up, view.up_sign),
          .plot = std::move(plot)};
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

Series series_of(const Curve& curve, const char* name, const char* color, double scale = 1) {
  Series series{.name = name, .x = curve.seconds, .y = curve.values, .color = color};
  for (double& y : series.y) y *= scale;
  return series;
}

std::vector<Figure> error_figures(const RunEvaluation& evaluation, const Timeline& timeline) {
  constexpr double kCentimetres = 100;
  const TrajectoryErrors& final_poses = evaluation.final_poses;
  const TrajectoryErrors& online = evaluation.online_poses;
  const auto pair = [&](const char* title, const std::string& caption, const char* y_label,
                        const Curve& online_curve, const Curve& final_curve, double scale) {
    Figure figure{.title = title,
                  .caption = caption,
                  .attributes = "data-kind=\"time\"",
                  .plot = time_plot(timeline, y_label)};
    figure.plot.series = {series_of(online_curve, "live", kOnlineColor, scale),
                          series_of(final_curve, "final", kFinalColor, scale)};
    figure.plot.y_limits = from_zero(figure.plot.series);
    return figure;
  };
  return {pair("Absolute error over time",
               fmt::format("Distance from ground truth. RMSE {:.2f} cm, median {:.2f} cm, largest "
                           "{:.2f} cm.",
                           kCentimetres * final_poses.ate, kCentimetres * final_poses.ate_median,
                           kCentimetres * final_poses.ate_max),
               "ATE [cm]", online.ate_curve, final_poses.ate_curve, kCentimetres),
          pair("Relative error over time: translation",
               fmt::format("Error of the motion over one second. RMSE {:.2f} cm/s, {} pairs.",
                           kCentimetres * final_poses.rpe_translation, final_poses.rpe_pairs),
               "RPE [cm/s]", online.rpe_translation_curve, final_poses.rpe_translation_curve,
               kCentimetres),
          pair("Relative error over time: rotation",
               fmt::format("Error of the turn over one second. RMSE {:.2f} °/s.",
                           final_poses.rpe_rotation),
               "RPE [°/s]", online.rpe_rotation_curve, final_poses.rpe_rotation_curve, 1)};
}

Figure quality_figure(const RunLog& log, const Timeline& timeline) {
  Plot plot = time_plot(timeline, "share of points");
  Series inliers{.name = "inliers of the points in view", .x = {}, .y = {}, .color = kFinalColor};
  Series overlap{.name = "keyframe's points in view", .x = {}, .y = {}, .color = kOnlineColor};
  for (const FrameRecord& frame : log.frames) {
    const double seconds = seconds_since_start(log, frame.stamp);
    const bool measured = frame.status == FrameStatus::kTracked;
    inliers.x.push_back(seconds);
    inliers.y.push_back(measured ? static_cast<double>(frame.inlier_ratio) : kNaN);
    overlap.x.push_back(seconds);
    overlap.y.push_back(measured ? static_cast<double>(frame.overlap) : kNaN);
  }
  plot.series = {std::move(overlap), std::move(inliers)};
  plot.y_limits = Limits{0, 1.03};
  plot.marks = timeline.keyframes;
  return {.title = "Tracking quality",
          .caption = timeline.lost.empty() ? "Ticks below: keyframes."
                                           : "Ticks below: keyframes. Red: tracking was lost.",
          .attributes = "data-kind=\"time\"",
          .plot = std::move(plot)};
}

// Means over groups of frames, so that areas of many frames stay areas.
Figure time_figure(const RunLog& log, const Timeline& timeline) {
  Plot plot = time_plot(timeline, "time [ms]");
  plot.stacked = true;
  for (std::size_t k = 0; k < kStages.size(); ++k)
    plot.series.push_back({.name = std::string(kStages[k].name),
                           .x = {},
                           .y = {},
                           .color = std::string(kStageColors[k])});
  const std::size_t group = (log.frames.size() + kMostBars - 1) / kMostBars;
  std::vector<double> totals;
  for (std::size_t first = 0; first < log.frames.size(); first += group) {
    const std::size_t end = std::min(first + group, log.frames.size());
    double total = 0;
    for (std::size_t k = 0; k < kStages.size(); ++k) {
      double sum = 0;
      for (std::size_t i = first; i < end; ++i) sum += log.frames[i].milliseconds.*kStages[k].time;
      plot.series[k].x.push_back(seconds_since_start(log, log.frames[first].stamp));
      plot.series[k].y.push_back(sum / static_cast<double>(end - first));
      total += plot.series[k].y.back();
    }
    totals.push_back(total);
  }
  // One slow frame (the first touches fresh memory) must not flatten all others.
  const double usual = 1.6 * quantile(totals, 0.99);
  const double highest = totals.empty() ? 1 : *std::max_element(totals.begin(), totals.end());
  plot.y_limits = Limits{0, std::max(1e-3, std::min(1.06 * highest, usual))};
  std::erase_if(plot.series, [](const Series& series) {
    return std::all_of(series.y.begin(), series.y.end(), [](double y) { return y <= 0; });
  });
  return {
      .title = "Time per frame",
      .caption = group > 1 ? fmt::format("By stage; means of {} frames each.", group) : "By stage.",
      .attributes = "data-kind=\"stack\"",
      .plot = std::move(plot)};
}

}  // namespace

std::string plots_of(const RunSummary& summary, const RunLog& log, const RunOutcome& outcome) {
  const Timeline timeline = make_timeline(log);
  const View& side = summary.run.camera.pinhole.fy < 0 ? kSideViewOfUpwardY : kSideView;
  std::vector<Figure> figures = {map_figure(kTopView, summary, outcome, timeline),
                                 map_figure(side, summary, outcome, timeline)};
  if (summary.evaluation)
    for (Figure& figure : error_figures(*summary.evaluation, timeline))
      figures.push_back(std::move(figure));
  figures.push_back(quality_figure(log, timeline));
  figures.push_back(time_figure(log, timeline));
  std::string html;
  for (const Figure& figure : figures) html += to_html(figure);
  return html;
}

std::string route_of(const RunLog& log, const Trajectory& trajectory) {
  const std::size_t step = trajectory.size() / kMostRoutePoints + 1;
  std::string json = "[";
  std::size_t frame = 0;
  for (std::size_t i = 0; i < trajectory.size(); i += step) {
    const StampedPose& pose = trajectory[i];
    while (frame + 1 < log.frames.size() && log.frames[frame].stamp < pose.stamp) ++frame;
    const Eigen::Vector3d& p = pose.world_from_camera.translation;
    json += fmt::format("{}[{:.3f},{},{:.3f},{:.3f},{:.3f}]", i == 0 ? "" : ",",
                        seconds_since_start(log, pose.stamp), log.frames[frame].index, p.x(), p.y(),
                        p.z());
  }
  return json + "]";
}

}  // namespace edvo
