// SPDX-License-Identifier: MIT
#include "edvo/report/summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>

namespace edvo {
namespace {

using Json = nlohmann::ordered_json;

// Enough digits for any use, few enough to read. JSON knows no NaN or infinity: they become null.
Json number(double value, int decimals) {
  if (!std::isfinite(value)) return nullptr;
  const double scale = std::pow(10.0, decimals);
  const double scaled = value * scale;
  constexpr double kExact = 1e15;  // beyond this a double has no such decimals to cut
  return std::abs(scaled) < kExact ? std::round(scaled) / scale : value;
}

constexpr int kPoseDecimals = 9;
constexpr int kMillisecondDecimals = 3;
constexpr int kRatioDecimals = 4;

Json pose_array(const SE3& pose) {
  Json array = Json::array();
  for (int i = 0; i < 3; ++i) array.push_back(number(pose.translation[i], kPoseDecimals));
  const Eigen::Vector4d xyzw = pose.rotation.coeffs();
  for (int i = 0; i < 4; ++i) array.push_back(number(xyzw[i], kPoseDecimals));
  return array;
}

Json levels_array(std::span<const LevelStats> levels) {
  Json array = Json::array();
  for (const LevelStats& level : levels)
    array.push_back({{"level", level.level},
                     {"iterations", level.iterations},
                     {"points", level.points},
                     {"cost", number(level.cost, 6)},
                     {"converged", level.converged}});
  return array;
}

// The information matrix spans many orders of magnitude: seven significant digits of each.
Json upper_triangle(const Matrix6d& information) {
  Json array = Json::array();
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column) {
      const double value = information(row, column);
      if (std::isfinite(value)) {
        array.push_back(std::stod(fmt::format("{:.7g}", value)));
      } else {
        array.push_back(nullptr);
      }
    }
  return array;
}

Json stage_times(const StageTimes& times) {
  Json object = Json::object();
  for (const Stage& stage : kStages)
    object[std::string(stage.name)] = number(times.*stage.time, kMillisecondDecimals);
  object["total"] = number(times.total, kMillisecondDecimals);
  return object;
}

Json to_json(const TimeStatistics& times) {
  return {{"mean", number(times.mean, kMillisecondDecimals)},
          {"median", number(times.median, kMillisecondDecimals)},
          {"p95", number(times.p95, kMillisecondDecimals)},
          {"p99", number(times.p99, kMillisecondDecimals)}};
}

Json to_json(const Machine& machine) {
  return {{"processor", machine.processor},
          {"hardware_threads", machine.hardware_threads},
          {"operating_system", machine.operating_system},
          {"compiler", machine.compiler},
          {"opencv", machine.opencv},
          {"eigen", machine.eigen}};
}

Json camera_object(const RunDescription& run) {
  const Camera& pinhole = run.camera.pinhole;
  return {{"origin", run.camera_origin},
          {"fx", pinhole.fx},
          {"fy", pinhole.fy},
          {"cx", pinhole.cx},
          {"cy", pinhole.cy},
          {"width", pinhole.width},
          {"height", pinhole.height},
          {"distortion_model", distortion_model(run.camera)},
          {"distortion", distortion_coefficients(run.camera)}};
}

Json skipped_array(const std::vector<SkippedFrame>& skipped) {
  Json array = Json::array();
  for (const SkippedFrame& frame : skipped)
    array.push_back({{"index", frame.index}, {"stamp", frame.stamp}, {"reason", frame.reason}});
  return array;
}

Json to_json(const TrajectoryErrors& errors) {
  Json json = {
      {"ate_rmse_m", number(errors.ate, 6)},     {"ate_median_m", number(errors.ate_median, 6)},
      {"ate_max_m", number(errors.ate_max, 6)},  {"ate_pairs", errors.ate_pairs},
      {"rpe_translation_rmse_m_per_s", nullptr}, {"rpe_rotation_rmse_deg_per_s", nullptr},
      {"rpe_pairs", errors.rpe_pairs},           {"drift_percent", nullptr}};
  if (errors.rpe_pairs > 0) {
    json["rpe_translation_rmse_m_per_s"] = number(errors.rpe_translation, 6);
    json["rpe_rotation_rmse_deg_per_s"] = number(errors.rpe_rotation, 6);
  }
  if (errors.drift) json["drift_percent"] = number(*errors.drift, 4);
  return json;
}

Json causes_object(const FrameCounts& counts) {
  Json object = Json::object();
  for (const auto& [cause, count] : counts.causes) object[std::string(name_of(cause))] = count;
  return object;
}

Json to_json(const RunEvaluation& evaluation) {
  return {{"ground_truth", evaluation.ground_truth},
          {"protocol", evaluation.protocol},
          {"sim3_scale", number(evaluation.scale, 6)},
          {"final", to_json(evaluation.final_poses)},
          {"online", to_json(evaluation.online_poses)}};
}

template <typename Value>
TimeStatistics statistics_of(const std::vector<FrameRecord>& frames, Value&& value) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const FrameRecord& frame : frames) values.push_back(value(frame));
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return {.mean = sum / static_cast<double>(std::max<std::size_t>(1, values.size())),
          .median = quantile(values, 0.5),
          .p95 = quantile(values, 0.95),
          .p99 = quantile(values, 0.99)};
}

// File names and paths need not be valid UTF-8; JSON text must be.
std::string dump(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const double position = p * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double fraction = position - static_cast<double>(below);
  return values[below] + fraction * (values[above] - values[below]);
}

double frames_per_second(const RunSummary& summary) {
  const auto processed = static_cast<double>(frames_processed(summary.counts));
  return summary.wall_seconds > 0 ? processed / summary.wall_seconds : 0.0;
}

std::optional<std::int64_t> slowest_second(const std::vector<FrameRecord>& frames) {
  std::optional<std::int64_t> fewest;
  double begin = 0;
  std::size_t end = 0;  // the first frame that is not finished within a second
  for (std::size_t first = 0; first < frames.size(); ++first) {
    while (end < frames.size() && frames[end].finished <= begin + 1) ++end;
    if (end == frames.size()) break;  // no whole second is left
    const auto count = static_cast<std::int64_t>(end - first);
    fewest = std::min(fewest.value_or(count), count);
    begin = frames[first].finished;
  }
  return fewest;
}

std::string config_hash(std::string_view config) {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV offset basis
  for (const char c : config) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 0x100000001b3;  // FNV prime
  }
  return fmt::format("{:016x}", hash);
}

RunDescription describe_run(const SourceInfo& source, const std::string& command,
                            const std::string& method, const std::string& config) {
  return {.sequence = source.name,
          .source = source.origin,
          .command = command,
          .method = method,
          .config = config,
          .camera = source.camera,
          .camera_origin = source.camera_origin,
          .depth_scale = source.depth_scale,
          .depth_origin = source.depth_origin,
          .is_depth_assumed = source.is_depth_assumed,
          .frames = source.frames,
          .seed = source.seed,
          .notes = source.notes,
          .warnings = source.warnings};
}

RunSummary summarize(const RunDescription& run, const RunLog& log, const RunOutcome& outcome) {
  RunSummary summary{.run = run,
                     .machine = this_machine(),
                     .counts = outcome.counts,
                     .keyframes = static_cast<std::int64_t>(outcome.keyframes.size()),
                     .skipped = log.skipped,
                     .path_length = path_length(outcome.trajectory),
                     .wall_seconds = outcome.wall_seconds,
                     .finish_seconds = outcome.finish_seconds,
                     .peak_memory = peak_memory(),
                     .slowest_second = slowest_second(log.frames),
                     .interrupted = outcome.interrupted,
                     .error = outcome.error ? outcome.error->what() : "",
                     .evaluation = outcome.evaluation,
                     .no_evaluation = outcome.no_evaluation};
  if (!log.frames.empty())
    summary.readout_seconds = static_cast<double>(log.frames.back().readout_seconds);
  for (const FrameRecord& frame : log.frames)
    summary.ego_share = std::max(summary.ego_share, static_cast<double>(frame.ego_share));
  bool was_lost = false;
  for (const FrameRecord& frame : log.frames) {
    const bool is_lost = frame.status == FrameStatus::kLost;
    if (is_lost && !was_lost) ++summary.lost_events;
    was_lost = is_lost;
  }
  const auto due = static_cast<double>(frames_due(outcome.counts));
  if (due > 0) summary.coverage = static_cast<double>(outcome.counts.tracked) / due;
  for (const Stage& stage : kStages)
    summary.stage_milliseconds.push_back(statistics_of(
        log.frames, [&](const FrameRecord& frame) { return frame.milliseconds.*stage.time; }));
  summary.total_milliseconds =
      statistics_of(log.frames, [](const FrameRecord& frame) { return frame.milliseconds.total; });
  return summary;
}

std::string to_json_line(const FrameResult& report) {
  Json line = {{"index", report.index},
               {"stamp", to_string(report.stamp)},
               {"status", name_of(report.status)},
               {"pose", pose_array(report.world_from_camera)},
               {"points", report.points},
               {"inlier_ratio", number(report.inlier_ratio, kRatioDecimals)},
               {"overlap", number(report.overlap, kRatioDecimals)},
               {"rms", number(report.rms, kRatioDecimals)},
               {"readout_ms", number(1e3 * report.readout_seconds, kMillisecondDecimals)},
               {"ego_share", number(report.ego_share, kRatioDecimals)},
               {"levels", levels_array(report.levels)},
               {"loss_cause", nullptr},
               {"segment", report.segment},
               {"keyframe", nullptr},
               {"keyframe_from_camera", pose_array(report.keyframe_from_camera)},
               {"new_keyframe", nullptr},
               {"keyframe_reason", nullptr},
               {"information", upper_triangle(report.information)},
               {"ms", stage_times(report.milliseconds)}};
  if (report.status == FrameStatus::kLost) line["loss_cause"] = name_of(report.loss_cause);
  if (report.keyframe >= 0) line["keyframe"] = report.keyframe;
  if (report.new_keyframe) line["new_keyframe"] = *report.new_keyframe;
  if (report.keyframe_reason) line["keyframe_reason"] = name_of(*report.keyframe_reason);
  return dump(line, -1);
}

std::string to_json_line(const SkippedFrame& skipped) {
  return dump({{"index", skipped.index},
               {"stamp", skipped.stamp},
               {"status", "skipped"},
               {"reason", skipped.reason}},
              -1);
}

std::string to_json_line(const LinkReport& link) {
  return dump({{"from", link.from},
               {"to", link.to},
               {"status", name_of(link.status)},
               {"similarity", number(link.similarity, kRatioDecimals)},
               {"matches", link.matches},
               {"inliers", link.inliers},
               {"translation_difference", link.translation_difference},
               {"rotation_difference", link.rotation_difference},
               {"overlap", number(link.overlap, kRatioDecimals)},
               {"correlation", number(link.correlation, kRatioDecimals)},
               {"seen_through", number(link.seen_through, kRatioDecimals)},
               {"alike", number(link.alike, kRatioDecimals)},
               {"cycle_chi_square", link.cycle_chi_square},
               {"from_pose_to", pose_array(link.from_pose_to)}},
              -1);
}

std::string to_json(const RunSummary& summary) {
  const RunDescription& run = summary.run;
  Json stages = Json::object();
  for (std::size_t i = 0; i < kStages.size(); ++i)
    stages[std::string(kStages[i].name)] = to_json(summary.stage_milliseconds[i]);
  stages["total"] = to_json(summary.total_milliseconds);
  Json json = {{"schema_version", kSchemaVersion},
               {"edvo_version", summary.machine.edvo},
               {"sequence", run.sequence},
               {"source", run.source},
               {"command", run.command},
               {"started", run.started},
               {"method", run.method},
               {"config_hash", config_hash(run.config)},
               {"seed", nullptr},
               {"interrupted", summary.interrupted},
               {"error", nullptr},
               {"camera", camera_object(run)},
               {"depth",
                {{"units_per_metre", run.depth_scale > 0 ? Json(run.depth_scale) : Json()},
                 {"origin", run.depth_origin},
                 {"assumed", run.is_depth_assumed}}},
               {"frames",
                {{"total", nullptr},
                 {"tracked", summary.counts.tracked},
                 {"relocalized", summary.counts.relocalized},
                 {"restarted", summary.counts.restarted},
                 {"lost", summary.counts.lost},
                 {"skipped", summary.counts.skipped},
                 {"dropped", summary.counts.dropped}}},
               {"segments", summary.counts.segments},
               {"loss_causes", causes_object(summary.counts)},
               {"coverage", number(summary.coverage, 6)},
               {"lost_events", summary.lost_events},
               {"keyframes", summary.keyframes},
               {"readout_ms", number(1e3 * summary.readout_seconds, kMillisecondDecimals)},
               {"ego_share", number(summary.ego_share, kRatioDecimals)},
               {"path_length_m", number(summary.path_length, 4)},
               {"wall_s", number(summary.wall_seconds, 3)},
               {"finish_s", number(summary.finish_seconds, 3)},
               {"frames_per_second", number(frames_per_second(summary), 2)},
               {"slowest_second_frames", nullptr},
               {"ms", stages},
               {"peak_memory_mb", number(summary.peak_memory, 1)},
               {"evaluation", nullptr},
               {"no_evaluation", nullptr},
               {"skipped", skipped_array(summary.skipped)},
               {"notes", run.notes},
               {"warnings", run.warnings},
               {"machine", to_json(summary.machine)}};
  if (run.frames) json["frames"]["total"] = *run.frames;
  if (!summary.error.empty()) json["error"] = summary.error;
  if (run.seed) json["seed"] = *run.seed;
  if (summary.slowest_second) json["slowest_second_frames"] = *summary.slowest_second;
  if (summary.evaluation) json["evaluation"] = to_json(*summary.evaluation);
  if (!summary.no_evaluation.empty()) json["no_evaluation"] = summary.no_evaluation;
  return dump(json, 2) + "\n";
}

}  // namespace edvo
