// SPDX-License-Identifier: MIT
#include "eval_tables.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace edvo::app {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kMissing = "-";

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
  const double frames = interval > 0 ? std::max(1.0, std::round(delta.value / interval)) : 1.0;
  switch (delta.unit) {
    case DeltaUnit::kSeconds:
      return fmt::format("{} --delta_unit f", frames);
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
  const EvalOptions options =
      evaluations.empty() ? EvalOptions{} : evaluations.front().evaluation.options;
  const std::string per = per_delta(options.rpe.delta);
  Table table{.header = {"name", "pairs", "coverage [%]", "time [s]", "ATE rmse [m]",
                         fmt::format("RPE trans [m{}]", per), fmt::format("RPE rot [deg{}]", per),
                         "drift [%]"},
              .rows = {}};
  if (options.alignment == AlignmentKind::kSim3) table.header.emplace_back("scale");
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
    if (options.alignment == AlignmentKind::kSim3)
      table.rows.back().push_back(fmt::format("{:.6f}", e.ate.truth_from_estimate.scale));
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
    json["estimates"].back()["evo"] =
        evo_commands(truth_file, named.file, named.estimate, named.evaluation.options);
  }
  // File names may hold anything, JSON only UTF-8.
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

std::vector<std::string> evo_commands(const std::string& truth_file,
                                      const std::string& estimate_file, const Trajectory& estimate,
                                      const EvalOptions& options) {
  std::string common =
      fmt::format("tum {} {}", shell_quoted(truth_file), shell_quoted(estimate_file));
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
                                   evo_delta(delta, estimate), all_pairs ? " --all_pairs" : "",
                                   relation));
  return commands;
}

}  // namespace edvo::app
