// SPDX-License-Identifier: MIT
// What residuals tell of a rolling shutter: how long the camera takes to read the rows of an image.
#pragma once

#include "edvo/align/align.hpp"

namespace edvo {

// Of one aligned frame: a least-squares estimate of the readout time, the pose and the brightness
// at their best, and its weight.
struct ReadoutEvidence {
  double seconds = 0;
  double information = 0;  // [1 / s^2] as if residuals were independent; 0 = tells nothing
};

// result: of aligning the frame to the reference at the finest level of the options. The velocities
// of both have to be known (RollingShutter::velocity).
[[nodiscard]] ReadoutEvidence readout_evidence(const Reference& reference, const Frame& frame,
                                               const AlignResult& result,
                                               const AlignOptions& options, AlignScratch& scratch);

}  // namespace edvo
