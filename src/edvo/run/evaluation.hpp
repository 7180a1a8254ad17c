// SPDX-License-Identifier: MIT
// Compares a run with ground truth.
#pragma once

#include "edvo/run/outcome.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <optional>
#include <string>

namespace edvo {

// Errors of the final poses (outcome.trajectory) and of the poses as known when their frame was
// processed (outcome.online), by the TUM protocol. Throws Error(kEvaluation) if they cannot be
// compared: no overlap in time, or too few poses.
[[nodiscard]] RunEvaluation evaluate_run(const GroundTruth& truth, const RunOutcome& outcome);

// A scale within 1 +- this tolerance counts as right.
inline constexpr double kScaleTolerance = 0.02;

// A warning that names the right depth scale, if the scale of the motion is wrong and explains most
// of the error. None if the source gives depth in metres or nothing is wrong.
[[nodiscard]] std::optional<std::string> warn_of_scale(const RunEvaluation& evaluation,
                                                       const SourceInfo& source);

}  // namespace edvo
