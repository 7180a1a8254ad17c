// SPDX-License-Identifier: MIT
#include "edvo/report/comparison.hpp"

#include "edvo/report/html_figure.hpp"
#include "edvo/report/html_page.hpp"
#include "edvo/report/html_space.hpp"
#include "edvo/report/markup.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace edvo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kCentimetres = 100;
// Okabe and Ito's colours, as in the plots of one run; then they come again.
constexpr std::array<const char*, 8> kRunColors = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                   "#e69f00", "#56b4e9", "#7f6000", "#7e57c2"};

struct Shown {
  const StoredRun* run = nullptr;
  std::string name, color;
  Timeline timeline;
  SE3 common_from_world;  // of the plots of all runs
  bool is_in_common = false;
};

// Both saw the same ground truth, each from its own world: any pose of it gives the motion between.
std::optional<SE3> motion_by_truth(const Trajectory& common, const Trajectory& world) {
  for (const StampedPose& pose : world) {
    const auto same = std::ranges::lower_bound(common, pose.stamp, {}, &StampedPose::stamp);
    if (same != common.end() && same->stamp == pose.stamp)
      return same->world_from_camera * inverse(pose.world_from_camera);
  }
  return std::nullopt;
}

const Trajectory& truth_of(const StoredRun& run) {
  static const Trajectory kNone;
  return run.summary.evaluation ? run.summary.evaluation->truth : kNone;
}

std::vector<Shown> show_all(const std::vector<StoredRun>& runs) {
  const std::vector<std::string> names = short_names(runs);
  std::vector<Shown> shown;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    shown.push_back({.run = &runs[i],
                     .name = names[i],
                     .color = kRunColors[i % kRunColors.size()],
                     .timeline = make_timeline(runs[i].log)});
    const auto motion = motion_by_truth(truth_of(runs.front()), truth_of(runs[i]));
    if (motion) shown.back().common_from_world = *motion;
    shown.back().is_in_common = i == 0 || motion.has_value();
  }
  return shown;
}

// --- the table -----------------------------------------------------------------------------------

using Cells = std::vector<std::string>;

std::string decimal(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "–";
}

Cells error_cells(const RunSummary& summary) {
  if (!summary.evaluation) return {"–", "–", "–", "–"};
  const TrajectoryErrors& errors = summary.evaluation->final_poses;
  const bool has_rpe = errors.rpe_pairs > 0;
  return {decimal(kCentimetres * errors.ate, 2),
          has_rpe ? decimal(kCentimetres * errors.rpe_translation, 2) : "–",
          has_rpe ? decimal(errors.rpe_rotation, 2) : "–",
          errors.drift ? decimal(*errors.drift, 2) : "–"};
}

std::string table_row(const Shown& shown) {
  const RunSummary& summary = shown.run->summary;
  Cells numbers = error_cells(summary);
  const FrameCounts& counts = summary.counts;
  for (std::string cell :
       {fmt::format("{} of {}", counts.tracked, frames_due(counts)),
        fmt::format("{} in {}", counts.lost, summary.lost_events),
        fmt::format("{}", counts.segments), fmt::format("{}", summary.keyframes),
        decimal(summary.total_milliseconds.median, 1), decimal(summary.total_milliseconds.p95, 1),
        decimal(frames_per_second(summary), 1), decimal(summary.peak_memory, 0)})
    numbers.push_back(std::move(cell));
  std::string row = fmt::format(
      "<tr><th scope=\"row\"><span class=\"swatch\" style=\"background:{}\"></span>{}</th>"
      "<td>{}</td><td>{}{}</td>",
      shown.color, escape_markup(shown.name), escape_markup(summary.run.sequence),
      escape_markup(summary.run.method), summary.interrupted ? ", interrupted" : "");
  for (const std::string& number : numbers) row += "<td class=\"number\">" + number + "</td>";
  return row + "</tr>\n";
}

std::string table_section(const std::vector<Shown>& shown) {
  std::string html =
      "<section class=\"card\"><h2>Summary</h2><div class=\"scroll "
      "compact\"><table><thead><tr><th>run</th>"
      "<th>sequence</th><th>method</th>";
  for (const char* heading :
       {"ATE [cm]", "RPE [cm/s]", "RPE [°/s]", "drift [%]", "tracked", "lost, in events",
        "segments", "keyframes", "median [ms]", "95 % [ms]", "frames/s", "memory [MB]"})
    html += fmt::format("<th class=\"number\">{}</th>", heading);
  html += "</tr></thead><tbody>\n";
  for (const Shown& run : shown) html += table_row(run);
  return html +
         "</tbody></table></div><p class=\"soft\">Errors are RMSE of the final poses, aligned "
         "by SE(3), RPE over 1 s; – = not known.</p></section>\n";
}

// What keeps the numbers from being compared, or is not shown.
std::vector<std::string> remarks_of(const std::vector<Shown>& shown) {
  std::vector<std::string> remarks;
  const RunDescription& first = shown.front().run->summary.run;
  for (const Shown& run : shown) {
    const RunSummary& summary = run.run->summary;
    if (summary.run.sequence != first.sequence)
      remarks.push_back(fmt::format("{}: another sequence ({}) than that of {} ({})", run.name,
                                    summary.run.sequence, shown.front().name, first.sequence));
    if (!summary.error.empty())
      remarks.push_back(fmt::format("{}: ended in an error: {}", run.name, summary.error));
    if (summary.interrupted) remarks.push_back(fmt::format("{}: stopped by the user", run.name));
    for (const std::string& missing : run.run->missing)
      remarks.push_back(fmt::format("{}: {}", run.name, missing));
  }
  return remarks;
}

std::string remarks_section(const std::vector<Shown>& shown) {
  std::string items;
  for (const std::string& remark : remarks_of(shown))
    items += "<li>" + escape_markup(remark) + "</li>";
  if (items.empty()) return "";
  return "<section class=\"card warnings\"><h2>Look at this</h2><ul>" + items + "</ul></section>\n";
}

// --- the plots -----------------------------------------------------------------------------------

Trajectory moved(const SE3& common_from_world, Trajectory trajectory) {
  for (StampedPose& pose : trajectory)
    pose.world_from_camera = common_from_world * pose.world_from_camera;
  return trajectory;
}

std::string frame_caption(const std::vector<Shown>& shown) {
  if (std::ranges::all_of(shown, &Shown::is_in_common))
    return "In the frame of the first run's first camera, by the ground truth.";
  return "Runs without common ground truth: each in the frame of its own first camera.";
}

Figure map_of(const View& view, const std::vector<Shown>& shown) {
  Figure figure = empty_map(view, frame_caption(shown));
  const auto add = [&](Series series, const std::string& name, const std::string& color) {
    series.name = name;
    series.color = color;
    figure.plot.series.push_back(std::move(series));
  };
  const Shown& first = shown.front();
  if (!truth_of(*first.run).empty())
    add(line_of(truth_of(*first.run), view, first.timeline, false), "ground truth", kTruthColor);
  for (const Shown& run : shown)
    add(line_of(moved(run.common_from_world, run.run->outcome.trajectory), view, run.timeline,
                true),
        run.name, run.color);
  return figure;
}

std::string space_of(const std::vector<Shown>& shown) {
  const Shown& first = shown.front();
  std::vector<SpaceLine> lines;
  if (!truth_of(*first.run).empty())
    lines.push_back(
        {.name = "ground truth", .color = kTruthColor, .trajectory = truth_of(*first.run)});
  for (const Shown& run : shown)
    lines.push_back({.name = run.name,
                     .color = run.color,
                     .trajectory = moved(run.common_from_world, run.run->outcome.trajectory),
                     .interrupted_by = &run.timeline});
  return space_card(lines, side_view(first.run->summary.run.camera.pinhole.fy).up_sign,
                    frame_caption(shown));
}

// value(run): a Series over time, without name and colour. No figure where no run has any value.
template <typename Value>
void add_figure(std::vector<Figure>& figures, const std::vector<Shown>& shown, const char* title,
                const char* y_label, Value&& value) {
  Timeline all;
  for (const Shown& run : shown) all.range.high = std::max(all.range.high, run.timeline.range.high);
  Figure figure{.title = title,
                .caption = {},
                .attributes = "data-kind=\"time\"",
                .plot = time_plot(all, y_label)};
  for (const Shown& run : shown) {
    Series series = value(*run.run);
    if (series.x.empty()) continue;
    series.name = run.name;
    series.color = run.color;
    figure.plot.series.push_back(std::move(series));
  }
  if (figure.plot.series.empty()) return;
  figure.plot.y_limits = from_zero(figure.plot.series);
  figures.push_back(std::move(figure));
}

void add_error_figure(std::vector<Figure>& figures, const std::vector<Shown>& shown,
                      const char* title, const char* y_label, Curve TrajectoryErrors::*curve,
                      double scale) {
  add_figure(figures, shown, title, y_label, [&](const StoredRun& run) {
    if (!run.summary.evaluation) return Series{};
    return series_of(run.summary.evaluation->final_poses.*curve, "", "", scale);
  });
}

template <typename Value>
Series over_frames(const RunLog& log, Value&& value) {
  Series series;
  for (const FrameRecord& frame : log.frames) {
    series.x.push_back(seconds_between(log.frames.front().stamp, frame.stamp));
    series.y.push_back(value(frame));
  }
  return series;
}

std::vector<Figure> figures_of(const std::vector<Shown>& shown) {
  const View& side = side_view(shown.front().run->summary.run.camera.pinhole.fy);
  std::vector<Figure> figures = {map_of(kTopView, shown), map_of(side, shown)};
  add_error_figure(figures, shown, "Absolute error over time", "ATE [cm]",
                   &TrajectoryErrors::ate_curve, kCentimetres);
  add_error_figure(figures, shown, "Relative error over time: translation", "RPE [cm/s]",
                   &TrajectoryErrors::rpe_translation_curve, kCentimetres);
  add_error_figure(figures, shown, "Relative error over time: rotation", "RPE [°/s]",
                   &TrajectoryErrors::rpe_rotation_curve, 1);
  add_figure(figures, shown, "Inliers", "share of the points in view", [](const StoredRun& run) {
    return over_frames(run.log, [](const FrameRecord& frame) {
      const bool is_aligned = is_tracked(frame.status) && frame.status != FrameStatus::kFirst;
      return is_aligned ? static_cast<double>(frame.inlier_ratio) : kNaN;
    });
  });
  add_figure(figures, shown, "Time per frame", "time [ms]", [](const StoredRun& run) {
    return over_frames(run.log, [](const FrameRecord& frame) { return frame.milliseconds.total; });
  });
  return figures;
}

std::string runs_section(const std::vector<Shown>& shown) {
  std::string rows;
  for (const Shown& run : shown)
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td class=\"text\">{}<br>{}</td></tr>\n",
                        escape_markup(run.name), escape_markup(run.run->folder.string()),
                        escape_markup(run.run->summary.run.command));
  return "<section class=\"card wide\"><h2>Folders and commands</h2><table>" + rows +
         "</table></section>\n";
}

}  // namespace

std::vector<std::string> short_names(const std::vector<StoredRun>& runs) {
  std::vector<std::string> names, folders;
  for (const StoredRun& run : runs) {
    folders.push_back(run.folder.string());
    // "runs/a/" ends in an empty name.
    const std::filesystem::path folder =
        run.folder.has_filename() ? run.folder : run.folder.parent_path();
    names.push_back(folder.filename().string());
  }
  const std::set<std::string> distinct(names.begin(), names.end());
  return distinct.size() == names.size() ? names : folders;
}

std::string comparison_page(const std::vector<StoredRun>& runs) {
  const std::vector<Shown> shown = show_all(runs);
  const std::string title = fmt::format("Comparison of {} runs", runs.size());
  std::string body = fmt::format(
      "<header><div><h1>{}</h1><p class=\"soft\">RGB-D visual odometry, edvo "
      "{}</p></div></header>\n",
      title, escape_markup(this_machine().edvo));
  body += remarks_section(shown) + table_section(shown) + "<div class=\"grid\">\n";
  for (const Figure& figure : figures_of(shown)) body += to_html(figure);
  body += "</div>\n" + space_of(shown) + runs_section(shown);
  return html_page(title, body, "[]");
}

}  // namespace edvo
