// SPDX-License-Identifier: MIT
// Rendered sequences for tests: small, on one thread.
#pragma once

#include "edvo/synth/sequence.hpp"

namespace edvo::test {

// Half of the default camera.
inline constexpr Camera kQvgaCamera{
    .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5, .width = 320, .height = 240};

[[nodiscard]] inline synth::SyntheticSequence make_sequence(const synth::SequenceOptions& options,
                                                            const Camera& camera) {
  synth::SyntheticSequence sequence = synth::make_sequence(options, {camera, {}});
  sequence.threads = 1;
  return sequence;
}

}  // namespace edvo::test
