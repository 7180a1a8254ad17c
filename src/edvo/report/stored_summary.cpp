// SPDX-License-Identifier: MIT
#include "edvo/report/stored_summary.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/find_named.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

namespace edvo {
namespace {

using Json = nlohmann::json;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// null stands for what is not a number.
double number(const Json& object, const char* key) {
  const Json& value = object.at(key);
  return value.is_null() ? kNaN : value.get<double>();
}

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || found->is_null() ? "" : found->get<std::string>();
}

template <typename T>
std::optional<T> maybe(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  return found->get<T>();
}

template <typename Enum>
Enum named(const std::string& wanted) {
  if (const auto value = find_named<Enum>(wanted)) return *value;
  throw Error(ErrorCode::kInput, fmt::format("'{}' is none of the known values", wanted));
}

TimeStatistics times_from(const Json& json) {
  return {.mean = number(json, "mean"),
          .median = number(json, "median"),
          .p95 = number(json, "p95"),
          .p99 = number(json, "p99")};
}

TrajectoryErrors errors_from(const Json& json) {
  TrajectoryErrors errors{.ate = number(json, "ate_rmse_m"),
                          .ate_median = number(json, "ate_median_m"),
                          .ate_max = number(json, "ate_max_m"),
                          .drift = maybe<double>(json, "drift_percent"),
                          .ate_pairs = json.at("ate_pairs").get<std::int64_t>(),
                          .rpe_pairs = json.at("rpe_pairs").get<std::int64_t>()};
  if (errors.rpe_pairs == 0) return errors;
  errors.rpe_translation = number(json, "rpe_translation_rmse_m_per_s");
  errors.rpe_rotation = number(json, "rpe_rotation_rmse_deg_per_s");
  return errors;
}

RunEvaluation evaluation_from(const Json& json) {
  return {.ground_truth = text_of(json, "ground_truth"),
          .protocol = text_of(json, "protocol"),
          .final_poses = errors_from(json.at("final")),
          .online_poses = errors_from(json.at("online")),
          .truth = {},
          .scale = number(json, "sim3_scale")};
}

DistortedCamera camera_from(const Json& json) {
  DistortedCamera camera{.pinhole = {.fx = number(json, "fx"),
                                     .fy = number(json, "fy"),
                                     .cx = number(json, "cx"),
                                     .cy = number(json, "cy"),
                                     .width = json.at("width").get<int>(),
                                     .height = json.at("height").get<int>()}};
  const auto coefficients = json.at("distortion").get<std::vector<double>>();
  std::copy_n(coefficients.begin(), std::min(coefficients.size(), camera.distortion.size()),
              camera.distortion.begin());
  if (text_of(json, "distortion_model") == "equidistant") camera.lens = LensModel::kEquidistant;
  return camera;
}

Machine machine_from(const Json& json) {
  const Json& machine = json.at("machine");
  return {.edvo = text_of(json, "edvo_version"),
          .compiler = text_of(machine, "compiler"),
          .opencv = text_of(machine, "opencv"),
          .eigen = text_of(machine, "eigen"),
          .processor = text_of(machine, "processor"),
          .hardware_threads = machine.at("hardware_threads").get<int>(),
          .operating_system = text_of(machine, "operating_system")};
}

FrameCounts counts_from(const Json& json) {
  const Json& frames = json.at("frames");
  std::map<LossCause, std::int64_t> causes;
  for (const auto& [cause, count] : json.at("loss_causes").items())
    causes[named<LossCause>(cause)] = count.get<std::int64_t>();
  return {.tracked = frames.at("tracked").get<std::int64_t>(),
          .lost = frames.at("lost").get<std::int64_t>(),
          .restarted = frames.at("restarted").get<std::int64_t>(),
          .skipped = frames.at("skipped").get<std::int64_t>(),
          .dropped = frames.at("dropped").get<std::int64_t>(),
          .relocalized = frames.at("relocalized").get<std::int64_t>(),
          .segments = json.at("segments").get<std::int64_t>(),
          .causes = causes};
}

RunDescription description_from(const Json& json) {
  const Json& depth = json.at("depth");
  return {.sequence = text_of(json, "sequence"),
          .source = text_of(json, "source"),
          .command = text_of(json, "command"),
          .started = text_of(json, "started"),
          .method = text_of(json, "method"),
          .config = {},
          .camera = camera_from(json.at("camera")),
          .camera_origin = text_of(json.at("camera"), "origin"),
          .depth_scale = maybe<double>(depth, "units_per_metre").value_or(0),
          .depth_origin = text_of(depth, "origin"),
          .is_depth_assumed = depth.at("assumed").get<bool>(),
          .frames = maybe<std::int64_t>(json.at("frames"), "total"),
          .seed = maybe<std::uint64_t>(json, "seed"),
          .notes = json.at("notes").get<std::vector<std::string>>(),
          .warnings = json.at("warnings").get<std::vector<std::string>>()};
}

RunSummary summary_from(const Json& json) {
  const int version = json.at("schema_version").get<int>();
  if (version != kSchemaVersion)
    throw Error(ErrorCode::kInput,
                fmt::format("schema_version {}, but this program reads {} only; use the edvo that "
                            "wrote it ({}), or run the sequence again",
                            version, kSchemaVersion, text_of(json, "edvo_version")));
  RunSummary summary{.run = description_from(json),
                     .machine = machine_from(json),
                     .counts = counts_from(json),
                     .lost_events = json.at("lost_events").get<std::int64_t>(),
                     .keyframes = json.at("keyframes").get<std::int64_t>(),
                     .skipped = {},
                     .readout_seconds = 1e-3 * maybe<double>(json, "readout_ms").value_or(0),
                     .ego_share = maybe<double>(json, "ego_share").value_or(0),
                     .path_length = number(json, "path_length_m"),
                     .wall_seconds = number(json, "wall_s"),
                     .finish_seconds = maybe<double>(json, "finish_s").value_or(0),
                     .peak_memory = number(json, "peak_memory_mb"),
                     .slowest_second = maybe<std::int64_t>(json, "slowest_second_frames"),
                     .interrupted = json.at("interrupted").get<bool>(),
                     .error = text_of(json, "error"),
                     .evaluation = {},
                     .no_evaluation = text_of(json, "no_evaluation"),
                     .coverage = number(json, "coverage")};
  for (const Json& skipped : json.at("skipped"))
    summary.skipped.push_back({.index = skipped.at("index").get<std::int64_t>(),
                               .stamp = text_of(skipped, "stamp"),
                               .reason = text_of(skipped, "reason")});
  if (!json.at("evaluation").is_null()) summary.evaluation = evaluation_from(json.at("evaluation"));
  const Json& times = json.at("ms");
  for (const Stage& stage : kStages)
    summary.stage_milliseconds.push_back(times_from(times.at(std::string(stage.name))));
  summary.total_milliseconds = times_from(times.at("total"));
  return summary;
}

Stamp stamp_from(const Json& json) {
  const std::string written = text_of(json, "stamp");
  if (const std::optional<Stamp> stamp = parse_stamp(written)) return *stamp;
  throw Error(ErrorCode::kInput, fmt::format("stamp '{}' is no time", written));
}

FrameRecord frame_from(const Json& json) {
  FrameRecord frame{
      .index = json.at("index").get<std::int64_t>(),
      .stamp = stamp_from(json),
      .status = named<FrameStatus>(text_of(json, "status")),
      .inlier_ratio = static_cast<float>(number(json, "inlier_ratio")),
      .overlap = static_cast<float>(number(json, "overlap")),
      .milliseconds = {},
      .rms = static_cast<float>(number(json, "rms")),
      .readout_seconds = static_cast<float>(1e-3 * maybe<double>(json, "readout_ms").value_or(0)),
      .ego_share = static_cast<float>(maybe<double>(json, "ego_share").value_or(0))};
  if (const auto reason = maybe<std::string>(json, "keyframe_reason"))
    frame.keyframe = named<KeyframeReason>(*reason);
  if (const auto cause = maybe<std::string>(json, "loss_cause"))
    frame.loss_cause = named<LossCause>(*cause);
  frame.new_keyframe = maybe<std::int64_t>(json, "new_keyframe").value_or(-1);
  const Json& times = json.at("ms");
  for (const Stage& stage : kStages)
    frame.milliseconds.*stage.time = number(times, std::string(stage.name).c_str());
  frame.milliseconds.total = number(times, "total");
  return frame;
}

// One object per line, told to use(object).
template <typename Use>
void for_each_line(std::string_view text, const std::string& source, Use&& use) {
  for (std::size_t begin = 0, line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    try {
      use(Json::parse(text.substr(begin, end - begin)));
    } catch (const std::exception& error) {
      throw Error(ErrorCode::kInput,
                  fmt::format("{}:{}: not what edvo writes: {}; run the sequence again", source,
                              line, error.what()));
    }
    begin = end + 1;
  }
}

}  // namespace

RunSummary parse_summary(std::string_view text, const std::string& source) {
  try {
    return summary_from(Json::parse(text));
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", source, error.what()));
  } catch (const Json::exception& error) {
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: not what edvo writes: {}; run the sequence again", source, error.what()));
  }
}

RunLog parse_frames(std::string_view text, const std::string& source) {
  RunLog log;
  for_each_line(text, source, [&](const Json& json) {
    if (json.at("status") == "skipped") {
      log.skipped.push_back({.index = json.at("index").get<std::int64_t>(),
                             .stamp = text_of(json, "stamp"),
                             .reason = text_of(json, "reason")});
    } else {
      log.frames.push_back(frame_from(json));
    }
  });
  return log;
}

std::vector<KeyframeLink> parse_links(std::string_view text, const std::string& source) {
  std::vector<KeyframeLink> links;
  for_each_line(text, source, [&](const Json& json) {
    if (json.at("status") == name_of(LinkStatus::kAccepted))
      links.push_back(
          {.from = json.at("from").get<std::int64_t>(), .to = json.at("to").get<std::int64_t>()});
  });
  return links;
}

}  // namespace edvo
