// SPDX-License-Identifier: MIT
// A recorded sequence as a run needs it: what `edvo run` and `edvo bench` have in common.
#pragma once

#include "edvo/io/camera_choice.hpp"
#include "edvo/io/dataset.hpp"
#include "run_loop.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace edvo::app {

// What the user says about a sequence.
struct SequenceChoice {
  std::filesystem::path path;
  std::optional<std::filesystem::path> camera_file;  // none = as the sequence tells
  std::optional<double> depth_scale;                 // [units/m], none = as the sequence tells
  std::int64_t first = 0;
  std::int64_t max_frames = 0;  // 0 = all
};

// The frames asked for, as [begin, end) of the data set's.
struct FrameRange {
  std::size_t begin = 0, end = 0;
};

struct OpenedSequence {
  Dataset dataset;
  ChosenCamera camera;
  FrameRange range;
};

// Unpacking an archive may take a while: it shows how far it is, unless quiet, and a signal stops
// it as it stops a run. Throws what open_dataset() and choose_camera() throw, and Error(kUsage) if
// there is no frame `first`.
[[nodiscard]] OpenedSequence open_sequence(const SequenceChoice& choice, bool quiet);

// Refers to the sequence.
[[nodiscard]] FrameInput input_from(const OpenedSequence& sequence);

[[nodiscard]] RunDescription describe_run(const OpenedSequence& sequence, const std::string& method,
                                          const Config& config);

// None, and a warning, if there is one that cannot be read: no reason not to track.
[[nodiscard]] std::optional<GroundTruth> read_ground_truth(const Dataset& dataset,
                                                           std::vector<std::string>& warnings);

}  // namespace edvo::app
