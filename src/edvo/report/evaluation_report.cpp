// SPDX-License-Identifier: MIT
#include "edvo/report/evaluation_report.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kMissing = "-";
constexpr std::string_view kTruthColor = "#8c8c8c";

ordered_json json_of(const Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
          {"std", s.std},   {"min", s.min},   {"max", s.max}};
}

ordered_json json_of(const EvalOptions& options) {
  return {{"description", describe_protocol(options)},
          {"rules", name_of(options.association.protocol)},
          {"max_difference_s", options.association.max_difference},
          {"offset_s", options.association.offset},
          {"alignment", name_of(options.alignment)},
          {"delta", to_string(options.rpe.delta)},
          {"max_pairs", options.rpe.max_pairs},
          {"seed", options.rpe.seed},
          {"coverage", describe_coverage(options)}};
}

ordered_json json_of(const Similarity& a) {
  const Eigen::Vector3d& t = a.motion.translation;
  const Eigen::Quaterniond& q = a.motion.rotation;
  return {{"scale", a.scale},
          {"translation_m", {t.x(), t.y(), t.z()}},
          {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

ordered_json json_of(const std::optional<Rpe>& rpe) {
  if (!rpe) return nullptr;
  return {{"pairs", rpe->errors.size()},
          {"void_pairs", rpe->void_pairs},
          {"translation_unit", "m" + per_delta(rpe->options.delta)},
          {"translation", json_of(rpe->translation)},
          {"rotation_unit", "deg" + per_delta(rpe->options.delta)},
          {"rotation", json_of(rpe->rotation)}};
}

ordered_json json_of(const Drift& drift) {
  ordered_json json = {{"distance_m", drift.distance}, {"path_length_m", drift.path_length}};
  json["percent"] = drift.percent ? ordered_json(*drift.percent) : ordered_json(nullptr);
  return json;
}

ordered_json json_of(const NamedEvaluation& named) {
  const Evaluation& e = named.evaluation;
  return {{"name", named.name},
          {"file", named.file},
          {"poses", e.poses},
          {"pairs", e.matches.size()},
          {"coverage", e.coverage},
          {"seconds", e.seconds},
          {"ate",
           {{"unit", "m"},
            {"pairs", e.ate.errors.size()},
            {"distance", json_of(e.ate.distance)},
            {"truth_from_estimate", json_of(e.ate.truth_from_estimate)}}},
          {"rpe", json_of(e.rpe)},
          {"drift", json_of(e.drift)},
          {"warnings", e.warnings}};
}

// All estimates share one clock, that of their first matched pose. [s]
Stamp first_stamp(std::span<const NamedEvaluation> evaluations) {
  Stamp first = evaluations.front().evaluation.ate.errors.front().stamp;
  for (const NamedEvaluation& named : evaluations)
    first = std::min(first, named.evaluation.ate.errors.front().stamp);
  return first;
}

// Longer than a few ordinary intervals nothing was estimated: a line there would be invented.
Series with_gaps(Series series) {
  constexpr double kLongGap = 5;  // [median intervals]
  std::vector<double> intervals;
  for (std::size_t i = 1; i < series.x.size(); ++i)
    intervals.push_back(series.x[i] - series.x[i - 1]);
  const double longest = kLongGap * median(intervals);
  Series broken{.name = series.name, .x = {}, .y = {}, .color = series.color};
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (i > 0 && series.x[i] - series.x[i - 1] > longest) {
      broken.x.push_back(std::nan(""));
      broken.y.push_back(std::nan(""));
    }
    broken.x.push_back(series.x[i]);
    broken.y.push_back(series.y[i]);
  }
  return broken;
}

Plot rpe_plot(std::span<const NamedEvaluation> evaluations, const std::string& what,
              const std::string& unit, double RpeError::*error) {
  Plot plot{.title = fmt::format("{} error over time, RPE", what),
            .x_label = "time [s]",
            .y_label = {},
            .series = {}};
  const Stamp start = evaluations.empty() ? Stamp{} : first_stamp(evaluations);
  for (const auto& [name, file, estimate, evaluation] : evaluations) {
    plot.y_label =
        fmt::format("{} error [{}{}]", what, unit, per_delta(evaluation.options.rpe.delta));
    plot.series.push_back({.name = name, .x = {}, .y = {}});
    if (!evaluation.rpe || evaluation.options.rpe.delta.unit == DeltaUnit::kAllPairs) continue;
    std::vector<RpeError> errors = evaluation.rpe->errors;
    std::sort(errors.begin(), errors.end(),
              [](const RpeError& a, const RpeError& b) { return a.from < b.from; });
    for (const RpeError& e : errors) {
      plot.series.back().x.push_back(seconds_between(start, e.from));
      plot.series.back().y.push_back(e.*error);
    }
    plot.series.back() = with_gaps(plot.series.back());
  }
  return plot;
}

// The two axes to draw, horizontal first, leaving out the one of the smallest extent.
std::array<Eigen::Index, 2> widest_axes(const Trajectory& truth) {
  Eigen::AlignedBox3d box;
  for (const StampedPose& pose : truth) box.extend(pose.world_from_camera.translation);
  Eigen::Index narrowest = 2;
  box.sizes().minCoeff(&narrowest);
  if (narrowest == 0) return {1, 2};
  if (narrowest == 1) return {0, 2};
  return {0, 1};
}

Series seen_along(const Trajectory& trajectory, const std::array<Eigen::Index, 2>& axes,
                  const std::string& name) {
  Series series{.name = name, .x = {}, .y = {}};
  for (const StampedPose& pose : trajectory) {
    series.x.push_back(pose.world_from_camera.translation[axes[0]]);
    series.y.push_back(pose.world_from_camera.translation[axes[1]]);
  }
  return series;
}

// Ground truth is often recorded before and after the images: that part belongs to no estimate.
Trajectory during(const Trajectory& truth, std::span<const NamedEvaluation> evaluations) {
  std::size_t first = truth.size(), last = 0;
  for (const NamedEvaluation& named : evaluations) {
    first = std::min(first, named.evaluation.matches.front().truth);
    last = std::max(last, named.evaluation.matches.back().truth);
  }
  if (first > last) return {};
  return {truth.begin() + static_cast<std::ptrdiff_t>(first),
          truth.begin() + static_cast<std::ptrdiff_t>(last) + 1};
}

std::string shell_quoted(const std::string& text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./=:,@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

double median_interval(const Trajectory& trajectory) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    intervals.push_back(seconds_between(trajectory[i - 1].stamp, trajectory[i].stamp));
  return median(intervals);
}

std::string evo_delta(const Delta& delta, const Trajectory& estimate) {
  const double interval = median_interval(estimate);
  switch (delta.unit) {
    case DeltaUnit::kSeconds:
      return fmt::format("{:.0f} --delta_unit f",
                         interval > 0 ? std::max(1.0, std::round(delta.value / interval)) : 1.0);
    case DeltaUnit::kFrames:
      return fmt::format("{} --delta_unit f", delta.value);
    case DeltaUnit::kMetres:
      return fmt::format("{} --delta_unit m", delta.value);
    case DeltaUnit::kRadians:
      return fmt::format("{} --delta_unit r", delta.value);
    case DeltaUnit::kDegrees:
      return fmt::format("{} --delta_unit d", delta.value);
    case DeltaUnit::kAllPairs:
      break;
  }
  return {};
}

}  // namespace

Table evaluation_table(std::span<const NamedEvaluation> evaluations) {
  const Delta delta =
      evaluations.empty() ? Delta{} : evaluations.front().evaluation.options.rpe.delta;
  Table table{.header = {"name", "pairs", "coverage [%]", "time [s]", "ATE rmse [m]",
                         fmt::format("RPE trans [m{}]", per_delta(delta)),
                         fmt::format("RPE rot [deg{}]", per_delta(delta)), "drift [%]"},
              .rows = {}};
  for (const auto& [name, file, estimate, e] : evaluations) {
    const auto or_missing = [](bool known, double value, int decimals) {
      return known ? fmt::format("{:.{}f}", value, decimals) : std::string(kMissing);
    };
    const bool has_rpe = e.rpe.has_value();
    table.rows.push_back(
        {name, std::to_string(e.matches.size()), fmt::format("{:.1f}", 100.0 * e.coverage),
         fmt::format("{:.1f}", e.seconds), fmt::format("{:.6f}", e.ate.distance.rmse),
         or_missing(has_rpe, has_rpe ? e.rpe->translation.rmse : 0, 6),
         or_missing(has_rpe, has_rpe ? e.rpe->rotation.rmse : 0, 6),
         or_missing(e.drift.percent.has_value(), e.drift.percent.value_or(0), 3)});
  }
  return table;
}

std::string evaluation_json(const std::string& truth_file, const Trajectory& truth,
                            std::span<const NamedEvaluation> evaluations) {
  ordered_json json;
  json["schema"] = 1;
  json["ground_truth"] = {{"file", truth_file}, {"poses", truth.size()}};
  json["protocol"] =
      evaluations.empty() ? ordered_json(nullptr) : json_of(evaluations.front().evaluation.options);
  json["estimates"] = ordered_json::array();
  for (const NamedEvaluation& named : evaluations) {
    json["estimates"].push_back(json_of(named));
    json["estimates"].back()["evo"] = evo_commands(truth_file, named);
  }
  // File names may hold anything, JSON only UTF-8.
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

Plot trajectory_plot(const Trajectory& truth, std::span<const NamedEvaluation> evaluations) {
  constexpr std::string_view kAxes = "xyz";
  const Trajectory shown = during(truth, evaluations);
  const auto axes = widest_axes(shown);
  Plot plot{.title = fmt::format("Trajectories seen along {}",
                                 kAxes[static_cast<std::size_t>(3 - axes[0] - axes[1])]),
            .x_label = fmt::format("{} [m]", kAxes[static_cast<std::size_t>(axes[0])]),
            .y_label = fmt::format("{} [m]", kAxes[static_cast<std::size_t>(axes[1])]),
            .series = {seen_along(shown, axes, "ground truth")},
            .equal_axes = true};
  plot.series.front().color = kTruthColor;
  for (const auto& [name, file, estimate, evaluation] : evaluations)
    plot.series.push_back(
        seen_along(transformed(evaluation.ate.truth_from_estimate, estimate), axes, name));
  return plot;
}

Plot ate_plot(std::span<const NamedEvaluation> evaluations) {
  Plot plot{.title = "Position error over time, ATE",
            .x_label = "time [s]",
            .y_label = "position error [m]",
            .series = {}};
  const Stamp start = evaluations.empty() ? Stamp{} : first_stamp(evaluations);
  for (const auto& [name, file, estimate, evaluation] : evaluations) {
    Series series{.name = name, .x = {}, .y = {}};
    for (const AteError& error : evaluation.ate.errors) {
      series.x.push_back(seconds_between(start, error.stamp));
      series.y.push_back(error.distance);
    }
    plot.series.push_back(with_gaps(series));
  }
  return plot;
}

Plot rpe_translation_plot(std::span<const NamedEvaluation> evaluations) {
  return rpe_plot(evaluations, "Translation", "m", &RpeError::translation);
}

Plot rpe_rotation_plot(std::span<const NamedEvaluation> evaluations) {
  return rpe_plot(evaluations, "Rotation", "deg", &RpeError::rotation);
}

std::vector<std::string> evo_commands(const std::string& truth_file, const NamedEvaluation& named) {
  const EvalOptions& options = named.evaluation.options;
  std::string common = fmt::format("tum {} {}", shell_quoted(truth_file), shell_quoted(named.file));
  if (options.alignment == AlignmentKind::kSe3) common += " -a";
  if (options.alignment == AlignmentKind::kSim3) common += " -as";
  common += fmt::format(" --t_max_diff {}", options.association.max_difference);
  if (options.association.offset != 0)
    common += fmt::format(" --t_offset {}", options.association.offset);
  std::vector<std::string> commands = {"evo_ape " + common};
  const Delta& delta = options.rpe.delta;
  if (delta.unit == DeltaUnit::kAllPairs) return commands;
  // The scripts start a pair at every pose, evo does so with --all_pairs.
  const bool all_pairs = options.association.protocol == Protocol::kTum;
  for (const char* relation : {"trans_part", "angle_deg"})
    commands.push_back(fmt::format("evo_rpe {} --delta {}{} --pose_relation {}", common,
                                   evo_delta(delta, named.estimate),
                                   all_pairs ? " --all_pairs" : "", relation));
  return commands;
}

}  // namespace edvo
