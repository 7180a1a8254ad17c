// SPDX-License-Identifier: MIT
#include "edvo/report/html.hpp"

#include "edvo/report/html_events.hpp"
#include "edvo/report/html_page.hpp"
#include "edvo/report/html_plots.hpp"
#include "edvo/report/markup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

namespace edvo {
namespace {

constexpr std::size_t kMostRows = 2000;  // of the table of keyframes

struct Tile {
  std::string name;
  std::string value, unit;
  std::string more;
  std::string mood = {};  // "good", "bad" or empty: the colour of the value
};

std::string to_html(const Tile& tile) {
  return fmt::format(
      "<div class=\"tile {}\"><div class=\"name\">{}</div><div class=\"value\">{}<small>{}</small>"
      "</div><div class=\"more\">{}</div></div>\n",
      tile.mood, tile.name, tile.value, tile.unit, tile.more);
}

std::string thousands(std::int64_t value) {
  std::string digits = fmt::format("{}", value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), "\u202f");  // narrow no-break space
  return digits;
}

std::string plural(std::int64_t count, const char* noun) {
  return fmt::format("{} {}{}", thousands(count), noun, count == 1 ? "" : "s");
}

std::vector<Tile> error_tiles(const RunEvaluation& evaluation) {
  const TrajectoryErrors& final_poses = evaluation.final_poses;
  const TrajectoryErrors& online = evaluation.online_poses;
  constexpr double kCentimetres = 100;
  std::vector<Tile> tiles = {
      {.name = "Absolute error (ATE)",
       .value = fmt::format("{:.2f}", kCentimetres * final_poses.ate),
       .unit = "cm",
       .more = fmt::format("RMSE, SE(3)-aligned<br>live {:.2f} cm", kCentimetres * online.ate)}};
  if (final_poses.rpe_pairs == 0 || online.rpe_pairs == 0) return tiles;
  tiles.push_back({.name = "Relative error (RPE)",
                   .value = fmt::format("{:.2f}", kCentimetres * final_poses.rpe_translation),
                   .unit = "cm/s",
                   .more = fmt::format("RMSE over 1 s<br>live {:.2f} cm/s",
                                       kCentimetres * online.rpe_translation)});
  tiles.push_back({.name = "Relative error, rotation",
                   .value = fmt::format("{:.2f}", final_poses.rpe_rotation),
                   .unit = "°/s",
                   .more = fmt::format("RMSE over 1 s<br>live {:.2f} °/s", online.rpe_rotation)});
  return tiles;
}

Tile drift_tile(double drift) {  // [%]
  constexpr double kBad = 5;
  return {.name = "Drift",
          .value = fmt::format("{:.2f}", drift),
          .unit = "%",
          .more = "of the path, at its end",
          .mood = drift > kBad ? "bad" : ""};
}

std::string tiles_section(const RunSummary& summary, const RunLog& log) {
  std::vector<Tile> tiles;
  const FrameCounts& counts = summary.counts;
  const bool complete = counts.lost == 0 && counts.skipped == 0 && !summary.interrupted;
  tiles.push_back(
      {.name = "Frames tracked",
       .value = thousands(counts.tracked),
       .unit = fmt::format("of {}", thousands(frames_due(counts))),
       .more =
           fmt::format("{} lost<br>{} skipped", thousands(counts.lost), thousands(counts.skipped)) +
           (counts.dropped > 0 ? fmt::format("<br>{} dropped", thousands(counts.dropped)) : ""),
       .mood = complete          ? "good"
               : counts.lost > 0 ? "bad"
                                 : ""});
  if (summary.evaluation)
    for (const Tile& tile : error_tiles(*summary.evaluation)) tiles.push_back(tile);
  tiles.push_back(
      {.name = "Speed",
       .value = fmt::format("{:.1f}", frames_per_second(summary)),
       .unit = "frames/s",
       .more = fmt::format("median {:.1f} ms<br>95 % within {:.1f} ms",
                           summary.total_milliseconds.median, summary.total_milliseconds.p95)});
  tiles.push_back({.name = "Keyframes",
                   .value = thousands(summary.keyframes),
                   .more = summary.keyframes > 0
                               ? fmt::format("one per {:.1f} frames",
                                             static_cast<double>(counts.tracked) /
                                                 static_cast<double>(summary.keyframes))
                               : "none"});
  tiles.push_back(
      {.name = "Lost events",
       .value = thousands(summary.lost_events),
       .more = (counts.lost > 0 ? plural(counts.lost, "frame") + " without a pose"
                                : std::string("every frame has a pose")) +
               (counts.segments > 1 ? fmt::format("<br>{} segments", counts.segments) : ""),
       .mood = summary.lost_events > 0 ? "bad" : ""});
  const double seconds =
      log.frames.empty() ? 0 : seconds_between(log.frames.front().stamp, log.frames.back().stamp);
  tiles.push_back({.name = "Path",
                   .value = fmt::format("{:.2f}", summary.path_length),
                   .unit = "m",
                   .more = fmt::format("in {:.1f} s", seconds)});
  if (summary.evaluation && summary.evaluation->final_poses.drift)
    tiles.push_back(drift_tile(*summary.evaluation->final_poses.drift));
  std::string html = "<section class=\"tiles\">\n";
  for (const Tile& tile : tiles) html += to_html(tile);
  return html + "</section>\n";
}

std::string list_of(const std::vector<std::string>& items) {
  std::string html = "<ul>";
  for (const std::string& item : items) html += "<li>" + escape_markup(item) + "</li>";
  return html + "</ul>";
}

std::string warnings_section(const RunSummary& summary) {
  std::vector<std::string> warnings = summary.run.warnings;
  if (!summary.error.empty())
    warnings.insert(warnings.begin(), "The run ended in an error: " + summary.error);
  if (summary.interrupted) {
    const std::string total =
        summary.run.frames ? fmt::format("of {} ", *summary.run.frames) : std::string();
    warnings.insert(warnings.begin(), fmt::format("Stopped by the user after {} {}frames.",
                                                  frames_due(summary.counts), total));
  }
  constexpr std::size_t kMostSkipped = 10;
  for (std::size_t i = 0; i < std::min(kMostSkipped, summary.skipped.size()); ++i)
    warnings.push_back(
        fmt::format("Frame {} skipped: {}", summary.skipped[i].index, summary.skipped[i].reason));
  if (summary.skipped.size() > kMostSkipped)
    warnings.push_back(fmt::format("{} more frames skipped; frames.jsonl names them all.",
                                   summary.skipped.size() - kMostSkipped));
  if (warnings.empty()) return "";
  return "<section class=\"card warnings\"><h2>Look at this</h2>" + list_of(warnings) +
         "</section>\n";
}

std::string header_of(const RunSummary& summary) {
  return fmt::format(
      "<header><svg width=\"46\" height=\"46\" viewBox=\"0 0 46 46\" fill=\"none\" "
      "stroke=\"#0072b2\" stroke-width=\"3\" stroke-linecap=\"round\" stroke-linejoin=\"round\">"
      "<path d=\"M5 33 17 12l12 8 12-13\"/><path d=\"M5 41h8l9-9 19 9\" stroke=\"#d55e00\"/>"
      "<g fill=\"#0072b2\" stroke=\"none\"><circle cx=\"17\" cy=\"12\" r=\"4\"/>"
      "<circle cx=\"29\" cy=\"20\" r=\"4\"/></g></svg>\n"
      "<div><h1>{}<span class=\"badge\">{}</span>{}</h1><p class=\"soft\">RGB-D visual odometry, "
      "edvo {} · {}</p></div></header>\n",
      escape_markup(summary.run.sequence), escape_markup(summary.run.method),
      summary.interrupted ? "<span class=\"badge bad\">interrupted</span>" : "",
      escape_markup(summary.machine.edvo), escape_markup(summary.run.started));
}

std::string keyframes_card(const RunLog& log) {
  std::map<std::string, std::int64_t> counts;
  std::string rows;
  std::size_t keyframes = 0;
  std::int64_t last = -1;
  for (const FrameRecord& frame : log.frames) {
    if (!frame.keyframe) continue;
    const std::string reason(name_of(*frame.keyframe));
    ++counts[reason];
    if (++keyframes <= kMostRows)
      rows += fmt::format(
          "<tr><td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td>"
          "<td class=\"number\">{}</td></tr>\n",
          frame.index, to_string(frame.stamp), reason,
          last < 0 ? std::string("–") : fmt::format("{}", frame.index - last));
    last = frame.index;
  }
  std::string reasons;
  for (const auto& [reason, count] : counts)
    reasons += fmt::format("{}{} {}", reasons.empty() ? "" : " · ", count, reason);
  if (keyframes > kMostRows)
    reasons += fmt::format(" · the first {} are shown, frames.jsonl has all", kMostRows);
  return fmt::format(
      "<section class=\"card\"><h2>Keyframes and their reasons</h2><p class=\"soft\">{}</p>"
      "<div class=\"scroll\"><table><thead><tr><th class=\"number\">frame</th><th class=\"number\">"
      "stamp [s]</th><th>reason</th><th class=\"number\">frames since the last</th></tr></thead>"
      "<tbody>\n{}</tbody></table></div></section>\n",
      reasons, rows);
}

const FrameRecord& frame_at(const RunLog& log, const Stamp& start, double seconds) {
  const auto distance = [&](const FrameRecord& frame) {
    return std::abs(seconds_between(start, frame.stamp) - seconds);
  };
  return *std::ranges::min_element(log.frames, {}, distance);
}

std::string worst_row(const std::string& what, const FrameRecord& frame, const std::string& value) {
  return fmt::format(
      "<tr><th scope=\"row\">{}</th><td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">{}</td></tr>\n",
      what, value, frame.index, to_string(frame.stamp));
}

// Where a curve is highest. Its gaps are NaN.
std::string highest_row(const std::string& what, const char* unit, const Curve& curve,
                        const RunLog& log, const Stamp& start) {
  const auto height = [](double value) { return std::isnan(value) ? -1.0 : value; };
  const auto highest = std::ranges::max_element(curve.values, {}, height);
  if (highest == curve.values.end() || std::isnan(*highest)) return "";
  const double seconds = curve.seconds[static_cast<std::size_t>(highest - curve.values.begin())];
  return worst_row(what, frame_at(log, start, seconds), fmt::format("{:.4g} {}", *highest, unit));
}

// The frames that one looks at first, each by the measure that it is the worst of.
std::string worst_card(const RunSummary& summary, const RunLog& log, const Stamp& start) {
  std::vector<FrameRecord> tracked;
  std::ranges::copy_if(log.frames, std::back_inserter(tracked), [](const FrameRecord& frame) {
    return frame.status == FrameStatus::kTracked;
  });
  if (tracked.empty()) return "";
  std::string rows;
  if (summary.evaluation) {
    const TrajectoryErrors& errors = summary.evaluation->final_poses;
    rows += highest_row("largest error of the position", "m", errors.ate_curve, log, start);
    rows += highest_row("largest RPE, middle of its second", "m/s", errors.rpe_translation_curve,
                        log, start);
    rows +=
        highest_row("largest RPE of the rotation", "°/s", errors.rpe_rotation_curve, log, start);
  }
  constexpr double kPercent = 100;
  const FrameRecord& inliers = *std::ranges::min_element(tracked, {}, &FrameRecord::inlier_ratio);
  const FrameRecord& overlap = *std::ranges::min_element(tracked, {}, &FrameRecord::overlap);
  const FrameRecord& slowest = *std::ranges::max_element(
      tracked, {}, [](const FrameRecord& frame) { return frame.milliseconds.total; });
  rows += worst_row("fewest inliers", inliers,
                    fmt::format("{:.1f} %", kPercent * inliers.inlier_ratio));
  rows += worst_row("least overlap with its keyframe", overlap,
                    fmt::format("{:.1f} %", kPercent * overlap.overlap));
  rows += worst_row("slowest", slowest, fmt::format("{:.2f} ms", slowest.milliseconds.total));
  return "<section class=\"card\"><h2>Extremes</h2><table><thead><tr><th>by</th>"
         "<th class=\"number\">value</th><th class=\"number\">frame</th>"
         "<th class=\"number\">stamp [s]</th></tr></thead><tbody>\n" +
         rows + "</tbody></table></section>\n";
}

std::string row(const std::string& name, const std::string& value) {
  return "<tr><th scope=\"row\">" + escape_markup(name) + "</th><td class=\"text\">" +
         escape_markup(value) + "</td></tr>\n";
}

std::string facts_card(const RunSummary& summary) {
  const RunDescription& run = summary.run;
  const Camera& camera = run.camera.pinhole;
  std::string table = row("source", run.source);
  table += row("camera", run.camera_origin);
  table += row("pinhole [px]",
               fmt::format("f {:.6g} {:.6g}, c {:.6g} {:.6g}, {} x {}", camera.fx, camera.fy,
                           camera.cx, camera.cy, camera.width, camera.height));
  if (is_distorted(run.camera))
    table += row("distortion", fmt::format("{}: {}", distortion_model(run.camera),
                                           fmt::join(distortion_coefficients(run.camera), " ")));
  if (summary.evaluation) {
    table += row("ground truth", summary.evaluation->ground_truth);
    table += row("protocol", summary.evaluation->protocol);
    table += row("scale (Sim(3))", fmt::format("{:.4f}", summary.evaluation->scale));
  } else if (!summary.no_evaluation.empty()) {
    table += row("no evaluation", summary.no_evaluation);
  }
  for (const std::string& note : run.notes) table += row("note", note);
  return "<section class=\"card\"><h2>What was read</h2><table>" + table + "</table></section>\n";
}

std::string stage_row(const std::string& swatch, std::string_view name,
                      const TimeStatistics& times) {
  return fmt::format(
      "<tr><td>{}{}</td><td class=\"number\">{:.2f}</td><td class=\"number\">{:.2f}</td>"
      "<td class=\"number\">{:.2f}</td><td class=\"number\">{:.2f}</td></tr>\n",
      swatch, name, times.mean, times.median, times.p95, times.p99);
}

std::string machine_card(const RunSummary& summary) {
  std::string stages;
  for (std::size_t i = 0; i < kStages.size(); ++i)
    stages += stage_row(
        fmt::format("<span class=\"swatch\" style=\"background:{}\"></span>", kStageColors[i]),
        kStages[i].name, summary.stage_milliseconds[i]);
  stages += stage_row("", "whole frame", summary.total_milliseconds);
  const Machine& machine = summary.machine;
  return "<section class=\"card\"><h2>Time per frame and the machine</h2><table><thead><tr>"
         "<th>stage [ms]</th><th class=\"number\">mean</th><th class=\"number\">median</th><th "
         "class=\"number\">95 %</th>"
         "<th class=\"number\">99 %</th></tr></thead><tbody>" +
         stages + "</tbody></table><table style=\"margin-top:12px\">" +
         row("processor",
             fmt::format("{}, {} threads", machine.processor, machine.hardware_threads)) +
         row("system", machine.operating_system) +
         row("built with", fmt::format("{}, OpenCV {}, Eigen {}", machine.compiler, machine.opencv,
                                       machine.eigen)) +
         row("run time",
             fmt::format("{:.1f} s, reading and writing included; {:.1f} s for the last pass",
                         summary.wall_seconds, summary.finish_seconds)) +
         row("peak memory", fmt::format("{:.0f} MB", summary.peak_memory)) + "</table></section>\n";
}

std::string reproduce_section(const RunSummary& summary) {
  std::string files;
  for (const char* name : {"trajectory.tum", "trajectory_online.tum", "keyframes.tum",
                           "frames.jsonl", "summary.json", "config.toml"})
    files += fmt::format("{}<a href=\"{}\">{}</a>", files.empty() ? "" : " · ", name, name);
  return fmt::format(
      "<section class=\"card wide\"><h2>Run it again<button id=\"copy\">copy</button></h2>"
      "<pre id=\"command\">{}</pre><p class=\"soft\" style=\"margin-top:8px\">Beside this page: "
      "{}</p></section>\n"
      "<section class=\"card wide\"><details><summary>Configuration <span class=\"soft\" "
      "style=\"font-weight:400\">{}</span></summary><pre>{}</pre></details></section>\n",
      escape_markup(summary.run.command), files, config_hash(summary.run.config),
      escape_markup(summary.run.config));
}

}  // namespace

std::string to_html(const RunSummary& summary, const RunLog& log, const RunOutcome& outcome) {
  std::string body = header_of(summary) + warnings_section(summary) + tiles_section(summary, log);
  body += "<div class=\"grid\">\n" + plots_of(summary, log, outcome) + "</div>\n" +
          space_of(summary, log, outcome) + worst_frames_section(log) + "<div class=\"grid\">\n" +
          events_card(log) + worst_card(summary, log, outcome.first_stamp) + keyframes_card(log) +
          facts_card(summary) + machine_card(summary) + "</div>\n" + reproduce_section(summary);
  return html_page(summary.run.sequence, body, route_of(log, outcome.trajectory));
}

}  // namespace edvo
