// SPDX-License-Identifier: MIT
// A run as the program does it, with a folder on disk and a line on the terminal: what `edvo run`,
// `edvo demo` and `edvo bench` have in common.
#pragma once

#include "edvo/report/summary.hpp"
#include "edvo/source/rgbd_source.hpp"
#include "extension.hpp"
#include "run_flags.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace edvo::app {

struct RecordedRun {
  RunSummary summary;
  std::filesystem::path folder;
  std::optional<Error> failure;           // with everything written
  std::optional<std::int64_t> localized;  // frames in the frame of --map; none = no map
};

// What the run's folder says of the source, the method and the command.
[[nodiscard]] RunDescription describe_run(const SourceInfo& source, const std::string& method,
                                          const Config& config);

// Tracks until the end or a signal to stop, writes the run's folder and evaluates against truth, or
// the source's own ground truth. Frames that cannot be read or used are skipped and counted.
// watcher: told as well; null = no one.
[[nodiscard]] RecordedRun record_run(RgbdSource& source, const RunDescription& description,
                                     const Config& config, const RunFlags& flags,
                                     const std::optional<GroundTruth>& truth = {},
                                     Observer* watcher = nullptr);

// All of `edvo run` and `edvo demo` once there is a source: shows what was chosen and the result,
// then throws the failure if there is one. findings: more warnings about the source.
void run_and_show(RgbdSource& source, const Config& config, const RunFlags& flags,
                  Observer* watcher = nullptr, const std::vector<std::string>& findings = {});

// Who the extension lets watch, by its options; null = no one.
[[nodiscard]] std::unique_ptr<Observer> make_observer(const Extension& extension,
                                                      Extension::Values values, bool force);

}  // namespace edvo::app
