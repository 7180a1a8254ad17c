// SPDX-License-Identifier: MIT
#include "edvo/report/html_plots.hpp"

#include "edvo/report/html_figure.hpp"
#include "edvo/report/html_space.hpp"
#include "edvo/report/markup.hpp"
#include "edvo/report/plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr std::size_t kMostRoutePoints = 1500;
constexpr std::size_t kMostBars = 1000;  // columns of the plot of times

constexpr const char* kFinalColor = "#0072b2";
constexpr const char* kOnlineColor = "#e69f00";
constexpr const char* kKeyframeColor = "#d55e00";

double seconds_since_start(const RunLog& log, const Stamp& stamp) {
  return seconds_between(log.frames.front().stamp, stamp);
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

Figure map_figure(const View& view, const RunSummary& summary, const RunOutcome& outcome,
                  const Timeline& timeline) {
  Figure figure = empty_map(view, "In the frame of the first camera.");
  const auto add = [&](Series series, const char* name, const char* color, double thickness) {
    series.name = name;
    series.color = color;
    series.thickness = thickness;
    figure.plot.series.push_back(std::move(series));
  };
  if (summary.evaluation)
    add(line_of(summary.evaluation->truth, view, timeline, false), "ground truth", kTruthColor,
        2.2);
  add(line_of(outcome.trajectory, view, timeline, true), "estimate", kFinalColor, 1.6);
  add(dots_of(outcome.keyframes, view), "keyframes", kKeyframeColor, 4);
  return figure;
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
  std::vector<Figure> figures = {
      map_figure(kTopView, summary, outcome, timeline),
      map_figure(side_view(summary.run.camera.pinhole.fy), summary, outcome, timeline)};
  if (summary.evaluation)
    for (Figure& figure : error_figures(*summary.evaluation, timeline))
      figures.push_back(std::move(figure));
  figures.push_back(quality_figure(log, timeline));
  figures.push_back(time_figure(log, timeline));
  std::string html;
  for (const Figure& figure : figures) html += to_html(figure);
  return html;
}

std::string space_of(const RunSummary& summary, const RunLog& log, const RunOutcome& outcome) {
  const Timeline timeline = make_timeline(log);
  std::vector<SpaceLine> lines;
  if (summary.evaluation)
    lines.push_back(
        {.name = "ground truth", .color = kTruthColor, .trajectory = summary.evaluation->truth});
  lines.push_back({.name = "estimate",
                   .color = kFinalColor,
                   .trajectory = outcome.trajectory,
                   .interrupted_by = &timeline});
  lines.push_back({.name = "keyframes",
                   .color = kKeyframeColor,
                   .trajectory = outcome.keyframes,
                   .is_dots = true});
  return space_card(lines, side_view(summary.run.camera.pinhole.fy).up_sign,
                    "In the frame of the first camera.");
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
