// SPDX-License-Identifier: MIT
// edvo run SEQUENCE
#include "commands.hpp"
#include "edvo/source/masked_source.hpp"
#include "python_package.hpp"
#include "recorded_run.hpp"
#include "sequence_input.hpp"
#include "size_option.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace edvo::app {
namespace {

struct Arguments {
  SequenceChoice sequence;
  std::string camera_size;  // WxH, empty = as the images
  std::string mask;         // image, empty = everything is used
  RunFlags run;
  Extension::Values extra;  // options of the extension
};

std::unique_ptr<RgbdSource> open_source(const SequenceChoice& sequence, const Arguments& arguments,
                                        const Extension& extension) {
  if (!extension.open_source) refuse_what_package_reads(sequence.path);
  if (extension.open_source)
    if (auto source = extension.open_source(sequence, arguments.extra)) return source;
  return std::make_unique<FolderSource>(open_sequence(sequence, arguments.run.quiet));
}

std::unique_ptr<RgbdSource> masked(std::unique_ptr<RgbdSource> source, const std::string& file) {
  if (file.empty()) return source;
  const Camera& camera = source->info().camera.pinhole;
  const cv::Mat_<std::uint8_t> mask = read_mask(file, {camera.width, camera.height});
  return std::make_unique<MaskedSource>(std::move(source), mask, file);
}

void run(const Arguments& arguments, const Extension& extension) {
  const Config config = resolve_config(arguments.run);
  SequenceChoice sequence = arguments.sequence;
  if (!arguments.camera_size.empty())
    sequence.camera_size = parse_size("--camera-size", arguments.camera_size);
  const std::unique_ptr<Observer> watcher =
      make_observer(extension, arguments.extra, arguments.run.force);
  const std::unique_ptr<RgbdSource> source =
      masked(open_source(sequence, arguments, extension), arguments.mask);
  std::vector<std::string> findings;
  if (extension.examine) findings = extension.examine(sequence, arguments.extra);
  run_and_show(*source, config, arguments.run, watcher.get(), findings);
}

}  // namespace

void add_run_command(CLI::App& program, const Extension& extension) {
  constexpr std::int64_t kMostFrames = 1'000'000'000;
  const auto arguments = std::make_shared<Arguments>();
  SequenceChoice& sequence = arguments->sequence;
  CLI::App* command = program.add_subcommand("run", "Track an RGB-D sequence and write a report");
  command
      ->add_option("sequence", sequence.path,
                   extension.open_source ? "Folder, archive, ROS bag or phone's recording"
                                         : "Folder or archive (.tgz, .zip)")
      ->required()
      ->type_name("SEQUENCE");
  command
      ->add_option("--camera", sequence.camera_file,
                   "Calibration: edvo TOML, OpenCV or ROS YAML, Kalibr camchain, or one line "
                   "fx fy cx cy [k1 k2 p1 p2 k3]")
      ->type_name("FILE");
  command
      ->add_option("--camera-size", arguments->camera_size,
                   "Size of the images that the camera was calibrated with; scales it to these")
      ->type_name("WIDTHxHEIGHT");
  command->add_option("--depth-scale", sequence.depth_scale, "Depth units per metre")
      ->type_name("UNITS");
  command
      ->add_option("--mask", arguments->mask,
                   "Image of the colour images' size, black where they show what moves with the "
                   "camera, as a robot's arm: not used")
      ->type_name("FILE");
  command->add_option("--start", sequence.first, "First frame, counted from 0")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{0}, kMostFrames));
  command->add_option("--max-frames", sequence.max_frames, "Stop after so many frames")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{1}, kMostFrames));
  add_run_flags(*command, arguments->run);
  add_extension_options(*command, extension.source_options, arguments->extra);
  add_extension_options(*command, extension.watch_options, arguments->extra);
  command->callback([arguments, &extension] { run(*arguments, extension); });
}

}  // namespace edvo::app
