// SPDX-License-Identifier: MIT
// Frames in, a run on disk and its summary out: what `edvo run` and `edvo demo` have in common.
#pragma once

#include "edvo/core/rgbd_image.hpp"
#include "edvo/report/summary.hpp"
#include "run_evaluation.hpp"
#include "run_options.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace edvo::app {

// Frames by their place among those asked for.
struct FrameInput {
  std::size_t count = 0;
  std::int64_t first_index = 0;                // in the sequence, of frame 0
  std::function<Stamp(std::size_t)> stamp_of;  // also of frames that cannot be read
  std::function<RgbdImage(std::size_t)> read;  // from several threads; throws Error(kInput)
};

struct RunResult {
  RunSummary summary;
  std::filesystem::path folder;
};

// Tracks every frame until the end or a signal to stop, writes the run's folder and evaluates
// against the ground truth if there is one. Frames that cannot be read or used are skipped and
// counted. Throws Error(kTrackingLost), after everything is written, if no frame could be tracked.
[[nodiscard]] RunResult run_frames(const FrameInput& input, const RunDescription& description,
                                   const Config& config, const std::optional<GroundTruth>& truth,
                                   const RunOptions& options);

// What was picked and why, and what looks wrong, on stderr; with --quiet only the latter.
void show_choices(const RunDescription& run, const RunOptions& options);

// The result on stdout: a table, or with --json the summary as one object. Then leaves with the
// status of an interrupted program if it was.
void show_result(const RunResult& result, const RunOptions& options);

}  // namespace edvo::app
