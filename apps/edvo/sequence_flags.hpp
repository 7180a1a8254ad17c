// SPDX-License-Identifier: MIT
// The flags of every verb that renders a sequence: --scene, --path, --frames, --noise, ...
#pragma once

#include "edvo/synth/sequence.hpp"

#include <CLI/CLI.hpp>
#include <string>

namespace edvo::app {

struct SequenceFlags {
  synth::SequenceOptions options;
  std::string trajectory;  // TUM file, empty = options.path
  std::string size;        // WxH, empty = that of the camera
  std::string camera;      // calibration file, empty = the default camera
};

void add_sequence_flags(CLI::App& verb, SequenceFlags& flags);

// Reads the files that the flags name and prepares the sequence. Throws Error(kUsage) on a bad size
// and what the readers throw; warnings about the trajectory go to stderr.
[[nodiscard]] synth::SyntheticSequence make_sequence(const SequenceFlags& flags);

}  // namespace edvo::app
