// SPDX-License-Identifier: MIT
#include "sequence_input.hpp"

#include "cache_folder.hpp"
#include "stop_signal.hpp"
#include "terminal.hpp"

#include <fmt/core.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

namespace edvo::app {

FolderSource open_sequence(const SequenceChoice& choice, bool quiet) {
  const StopSignal signal;
  bool shown = false;
  const bool is_shown = !quiet && isatty(STDERR_FILENO) != 0;
  const auto on_unpack = [&](double share) {
    if (stop_requested()) throw CLI::RuntimeError("interrupted", kInterruptedStatus);
    if (is_shown) say_bytes(fmt::format("\runpacking {:.0f} %", 100 * share));
    shown = is_shown;
  };
  FolderSource source(choice.path, {.camera_file = choice.camera_file,
                                    .camera_size = choice.camera_size,
                                    .depth_scale = choice.depth_scale,
                                    .first = choice.first,
                                    .max_frames = choice.max_frames,
                                    .cache = cache_folder(),
                                    .on_unpack = on_unpack});
  if (shown) say_bytes("\r\x1b[K");
  return source;
}

}  // namespace edvo::app
