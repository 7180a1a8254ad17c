// SPDX-License-Identifier: MIT
// A run against its ground truth.
#pragma once

#include "edvo/run/outcome.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <optional>
#include <string>

namespace edvo {

// Errors of the poses as known at the end (outcome.trajectory) and at the time (outcome.online), by
// the TUM protocol. Throws Error(kEvaluation) where they cannot be compared.
[[nodiscard]] RunEvaluation evaluate_run(const GroundTruth& truth, const RunOutcome& outcome);

// Within this share of 1 a scale is called right.
inline constexpr double kScaleTolerance = 0.02;

// Where the scale of the motion is off and explains most of its error: which depth scale would mend
// it. Empty where depth came in metres or nothing is wrong.
[[nodiscard]] std::optional<std::string> warn_of_scale(const RunEvaluation& evaluation,
                                                       const SourceInfo& source);

}  // namespace edvo
