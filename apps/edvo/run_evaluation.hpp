// SPDX-License-Identifier: MIT
// A run against its ground truth.
#pragma once

#include "edvo/report/summary.hpp"

#include <string>

namespace edvo::app {

struct GroundTruth {
  std::string source;  // its file, or what made it
  Trajectory trajectory;
};

// Errors of the poses as known at the end (outcome.trajectory) and at the time (log.online), by the
// TUM protocol. Throws Error(kEvaluation) where they cannot be compared.
[[nodiscard]] RunEvaluation evaluate_run(const GroundTruth& truth, const RunLog& log,
                                         const RunOutcome& outcome);

}  // namespace edvo::app
