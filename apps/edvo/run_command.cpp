// SPDX-License-Identifier: MIT
// edvo run SEQUENCE
#include "cache_folder.hpp"
#include "command_line.hpp"
#include "commands.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/dataset.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "run_loop.hpp"
#include "stop_signal.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace edvo::app {
namespace {

struct Arguments {
  std::string sequence;
  std::optional<std::filesystem::path> camera_file;  // none = as the sequence tells
  std::optional<double> depth_scale;
  std::int64_t first = 0;
  std::int64_t max_frames = 0;  // 0 = all
  RunOptions run;
};

// The frames asked for, as [begin, end) of the data set's.
struct FrameRange {
  std::size_t begin = 0, end = 0;
};

FrameRange choose_frames(const Dataset& dataset, const Arguments& arguments) {
  FrameRange range{.begin = static_cast<std::size_t>(arguments.first),
                   .end = dataset.frames.size()};
  if (range.begin >= range.end)
    throw Error(ErrorCode::kUsage, fmt::format("--start {}: {} has only {} frames", arguments.first,
                                               dataset.source.string(), range.end));
  if (arguments.max_frames > 0)
    range.end = std::min(range.end, range.begin + static_cast<std::size_t>(arguments.max_frames));
  return range;
}

FrameInput input_from(const Dataset& dataset, const FrameRange& range) {
  return {
      .count = range.end - range.begin,
      .first_index = static_cast<std::int64_t>(range.begin),
      .stamp_of = [&dataset,
                   range](std::size_t i) { return dataset.frames[range.begin + i].stamp; },
      .read = [&dataset, range](std::size_t i) { return read_frame(dataset, range.begin + i); }};
}

// Unpacking may take a while: it shows how far it is and can be stopped.
Dataset open(const Arguments& arguments) {
  const StopSignal signal;
  bool shown = false;
  const bool is_shown = !arguments.run.quiet && isatty(STDERR_FILENO) != 0;
  const auto on_unpack = [&](double share) {
    if (stop_requested()) throw CLI::RuntimeError("interrupted", kInterruptedStatus);
    if (is_shown) fmt::print(stderr, "\runpacking {:.0f} %", 100 * share);
    shown = is_shown;
  };
  Dataset dataset = open_dataset(
      arguments.sequence,
      {.depth_scale = arguments.depth_scale, .cache = cache_folder(), .on_unpack = on_unpack});
  if (shown) fmt::print(stderr, "\r\x1b[K");
  return dataset;
}

// A ground truth that cannot be read is no reason not to track.
std::optional<GroundTruth> read_ground_truth(const Dataset& dataset,
                                             std::vector<std::string>& warnings) {
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

RunDescription describe(const Dataset& dataset, const ChosenCamera& chosen, const FrameRange& range,
                        const Config& config, const Arguments& arguments) {
  return {
      .sequence = dataset.name,
      .source = fmt::format("{} ({})", dataset.source.string(), dataset.layout),
      .command = this_command(),
      .method = method_name(arguments.run),
      .config = to_toml(config),
      .camera = chosen.camera,
      .camera_origin = chosen.source,
      .depth_scale = dataset.depth_scale.units_per_metre,
      .depth_origin = fmt::format("{} units per metre ({})", dataset.depth_scale.units_per_metre,
                                  dataset.depth_scale.source),
      .frames = static_cast<std::int64_t>(range.end - range.begin),
      .notes = dataset.notes,
      .warnings = dataset.warnings};
}

void run(const Arguments& arguments) {
  const Config config = resolve_config(arguments.run.config);
  const Dataset dataset = open(arguments);
  const ChosenCamera camera = choose_camera(dataset, arguments.camera_file);
  const FrameRange range = choose_frames(dataset, arguments);
  RunDescription description = describe(dataset, camera, range, config, arguments);
  const std::optional<GroundTruth> truth = read_ground_truth(dataset, description.warnings);
  show_choices(description, arguments.run);
  show_result(run_frames(input_from(dataset, range), description, config, truth, arguments.run),
              arguments.run);
}

}  // namespace

void add_run_command(CLI::App& program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("run", "Track an RGB-D sequence and write a report");
  command->add_option("sequence", arguments->sequence, "Folder or archive (.tgz, .zip)")
      ->required()
      ->type_name("SEQUENCE");
  command
      ->add_option("--camera", arguments->camera_file,
                   "Calibration: edvo TOML, OpenCV or ROS YAML, Kalibr camchain, or one line "
                   "fx fy cx cy [k1 k2 p1 p2 k3]")
      ->type_name("FILE");
  command->add_option("--depth-scale", arguments->depth_scale, "Depth units per metre")
      ->type_name("UNITS");
  command->add_option("--start", arguments->first, "First frame, counted from 0")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--max-frames", arguments->max_frames, "Stop after so many frames")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  add_run_options(*command, arguments->run);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace edvo::app
