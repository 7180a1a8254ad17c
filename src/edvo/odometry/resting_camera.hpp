// SPDX-License-Identifier: MIT
// A camera at rest, before which something moves, seems to move along a little: a compromise that
// explains most of the image about as well, and nothing of it exactly. Or it seems to circle what
// turns before it.
#pragma once

#include "edvo/align/align.hpp"

#include <optional>

namespace edvo {

struct RestTest {
  std::optional<AlignResult> alignment;  // by what stands still: the camera is at rest
  bool contradicts = false;  // what is far away stands still: the motion is not the camera's
};

// Compares the motion of `first` with none at all since the reference keyframe, part by part of
// the image. largest: mean residual of a part that fits [grey levels].
[[nodiscard]] RestTest test_rest(const AlignResult& first, const Reference& reference,
                                 const Frame& frame, double largest, const AlignOptions& options,
                                 AlignScratch& scratch);

}  // namespace edvo
