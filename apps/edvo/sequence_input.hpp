// SPDX-License-Identifier: MIT
// A recorded sequence as the user names it: what `edvo run` and `edvo bench` have in common.
#pragma once

#include "edvo/source/folder_source.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>

namespace edvo::app {

// What the user says about a sequence.
struct SequenceChoice {
  std::filesystem::path path;
  std::optional<std::filesystem::path> camera_file;  // none = as the sequence tells
  cv::Size camera_size = {};               // [px] that it was calibrated for, empty = as the images
  std::optional<double> depth_scale = {};  // [units/m], none = as the sequence tells
  std::int64_t first = 0;
  std::int64_t max_frames = 0;  // 0 = all
};

// Unpacking an archive may take a while: it shows how far it is, unless quiet, and a signal stops
// it as it stops a run. Throws what FolderSource throws.
[[nodiscard]] FolderSource open_sequence(const SequenceChoice& choice, bool quiet);

}  // namespace edvo::app
