// SPDX-License-Identifier: MIT
#include "sequence_input.hpp"

#include "cache_folder.hpp"
#include "command_line.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "stop_signal.hpp"

#include <fmt/core.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>

namespace edvo::app {
namespace {

FrameRange choose_frames(const Dataset& dataset, const SequenceChoice& choice) {
  FrameRange range{.begin = static_cast<std::size_t>(choice.first), .end = dataset.frames.size()};
  if (range.begin >= range.end)
    throw Error(ErrorCode::kUsage, fmt::format("--start {}: {} has only {} frames", choice.first,
                                               dataset.source.string(), range.end));
  if (choice.max_frames > 0)
    range.end = std::min(range.end, range.begin + static_cast<std::size_t>(choice.max_frames));
  return range;
}

Dataset open(const SequenceChoice& choice, bool quiet) {
  const StopSignal signal;
  bool shown = false;
  const bool is_shown = !quiet && isatty(STDERR_FILENO) != 0;
  const auto on_unpack = [&](double share) {
    if (stop_requested()) throw CLI::RuntimeError("interrupted", kInterruptedStatus);
    if (is_shown) fmt::print(stderr, "\runpacking {:.0f} %", 100 * share);
    shown = is_shown;
  };
  Dataset dataset = open_dataset(
      choice.path,
      {.depth_scale = choice.depth_scale, .cache = cache_folder(), .on_unpack = on_unpack});
  if (shown) fmt::print(stderr, "\r\x1b[K");
  return dataset;
}

}  // namespace

OpenedSequence open_sequence(const SequenceChoice& choice, bool quiet) {
  OpenedSequence sequence{.dataset = open(choice, quiet), .camera = {}, .range = {}};
  sequence.camera = choose_camera(sequence.dataset, choice.camera_file);
  sequence.range = choose_frames(sequence.dataset, choice);
  return sequence;
}

FrameInput input_from(const OpenedSequence& sequence) {
  const Dataset& dataset = sequence.dataset;
  const FrameRange range = sequence.range;
  return {
      .count = range.end - range.begin,
      .first_index = static_cast<std::int64_t>(range.begin),
      .stamp_of = [&dataset,
                   range](std::size_t i) { return dataset.frames[range.begin + i].stamp; },
      .read = [&dataset, range](std::size_t i) { return read_frame(dataset, range.begin + i); }};
}

RunDescription describe_run(const OpenedSequence& sequence, const std::string& method,
                            const Config& config) {
  const Dataset& dataset = sequence.dataset;
  return {
      .sequence = dataset.name,
      .source = fmt::format("{} ({})", dataset.source.string(), dataset.layout),
      .command = this_command(),
      .method = method,
      .config = to_toml(config),
      .camera = sequence.camera.camera,
      .camera_origin = sequence.camera.source,
      .depth_scale = dataset.depth_scale.units_per_metre,
      .depth_origin = fmt::format("{} units per metre ({})", dataset.depth_scale.units_per_metre,
                                  dataset.depth_scale.source),
      .frames = static_cast<std::int64_t>(sequence.range.end - sequence.range.begin),
      .notes = dataset.notes,
      .warnings = dataset.warnings};
}

std::optional<GroundTruth> read_ground_truth(const Dataset& dataset,
                                             std::vector<std::string>& warnings) {
  if (!dataset.poses.empty()) return GroundTruth{dataset.poses_source, dataset.poses};
  if (!dataset.ground_truth) return std::nullopt;
  try {
    TrajectoryFile file = read_trajectory(*dataset.ground_truth);
    warnings.insert(warnings.end(), file.warnings.begin(), file.warnings.end());
    return GroundTruth{dataset.ground_truth->string(), std::move(file.trajectory)};
  } catch (const Error& error) {
    warnings.push_back(fmt::format("no evaluation: {}", error.what()));
    return std::nullopt;
  }
}

}  // namespace edvo::app
