// SPDX-License-Identifier: MIT
// A run against its ground truth.
#pragma once

#include "edvo/run/outcome.hpp"
#include "edvo/source/rgbd_source.hpp"

namespace edvo {

// Errors of the poses as known at the end (outcome.trajectory) and at the time (outcome.online), by
// the TUM protocol. Throws Error(kEvaluation) where they cannot be compared.
[[nodiscard]] RunEvaluation evaluate_run(const GroundTruth& truth, const RunOutcome& outcome);

}  // namespace edvo
