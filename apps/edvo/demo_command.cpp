// SPDX-License-Identifier: MIT
// edvo demo: tracks a sequence that is rendered on the way, so that there is something to see
// without any data.
#include "commands.hpp"
#include "edvo/synth/rendered_source.hpp"
#include "recorded_run.hpp"
#include "sequence_flags.hpp"

#include <memory>

namespace edvo::app {
namespace {

struct Arguments {
  SequenceFlags sequence;
  RunFlags run;
  Extension::Values extra;  // options of the extension
};

void run(const Arguments& arguments, const Extension& extension) {
  const Config config = resolve_config(arguments.run);
  const std::unique_ptr<Observer> watcher =
      make_observer(extension, arguments.extra, arguments.run.force);
  synth::RenderedSource source(make_sequence(arguments.sequence));
  run_and_show(source, config, arguments.run, watcher.get());
}

}  // namespace

void add_demo_command(CLI::App& program, const Extension& extension) {
  CLI::App* verb = program.add_subcommand(
      "demo", "Render a room, track the camera through it and write a report; needs no data");
  const auto arguments = std::make_shared<Arguments>();
  arguments->run.threads = 3;  // rendering costs more than tracking: two frames at a time
  // Ten seconds and five metres: as much to see as with the camera's 30 Hz, from half the frames.
  arguments->sequence.options.frames = 150;
  arguments->sequence.options.rate = 15;  // [Hz]
  add_run_flags(*verb, arguments->run);
  add_sequence_flags(*verb, arguments->sequence);
  add_extension_options(*verb, extension.watch_options, arguments->extra);
  verb->callback([arguments, &extension] { run(*arguments, extension); });
}

}  // namespace edvo::app
