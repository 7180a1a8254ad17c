// SPDX-License-Identifier: MIT
// edvo demo: tracks a sequence that is rendered on the way, so that there is something to see
// without any data.
#include "command_line.hpp"
#include "commands.hpp"
#include "run_loop.hpp"
#include "sequence_flags.hpp"

#include <fmt/core.h>

#include <memory>

namespace edvo::app {
namespace {

struct Arguments {
  SequenceFlags sequence;
  RunOptions run;
};

// Frames are made side by side rather than each by several threads.
FrameInput input_from(const synth::SyntheticSequence& sequence) {
  return {.count = static_cast<std::size_t>(synth::frame_count(sequence)),
          .first_index = 0,
          .stamp_of =
              [&sequence](std::size_t i) { return pose_of(sequence, static_cast<int>(i)).stamp; },
          .read = [&sequence](std::size_t i) { return make_frame(sequence, static_cast<int>(i)); }};
}

RunDescription describe(const synth::SyntheticSequence& sequence, const Config& config,
                        const RunOptions& options) {
  const synth::SequenceOptions& made = sequence.options;
  const std::string scene(name_of(made.scene));
  return {.sequence = "demo",
          .source = fmt::format("rendered: scene {}, path {}", scene,
                                sequence.path.recorded.empty() ? name_of(made.path) : "recorded"),
          .command = this_command(),
          .method = method_name(options),
          .config = to_toml(config),
          .camera = sequence.camera,
          .camera_origin = "the one that the images are rendered with",
          .depth_scale = 0,
          .depth_origin = "rendered in metres",
          .frames = synth::frame_count(sequence),
          .seed = static_cast<std::uint64_t>(made.seed),
          .notes = {fmt::format("noise of a Kinect-like sensor, seed {}", made.seed)},
          .warnings = {}};
}

void run(const Arguments& arguments) {
  const Config config = resolve_config(arguments.run.config);
  synth::SyntheticSequence sequence = make_sequence(arguments.sequence);
  sequence.threads = 1;
  const RunDescription description = describe(sequence, config, arguments.run);
  const GroundTruth truth{.source = "the rendered path", .trajectory = ground_truth(sequence)};
  show_choices(description, arguments.run);
  show_result(run_frames(input_from(sequence), description, config, truth, arguments.run),
              arguments.run);
}

}  // namespace

void add_demo_command(CLI::App& program) {
  CLI::App* verb = program.add_subcommand(
      "demo", "Render a room, track the camera through it and write a report; needs no data");
  const auto arguments = std::make_shared<Arguments>();
  arguments->run.threads = 3;  // rendering costs more than tracking: two frames at a time
  // Ten seconds and five metres: as much to see as with the camera's 30 Hz, from half the frames.
  arguments->sequence.options.frames = 150;
  arguments->sequence.options.rate = 15;  // [Hz]
  add_run_options(*verb, arguments->run);
  add_sequence_flags(*verb, arguments->sequence);
  verb->callback([arguments] { run(*arguments); });
}

}  // namespace edvo::app
