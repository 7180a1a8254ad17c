// SPDX-License-Identifier: MIT
// Absolute trajectory error: distances between the positions of the aligned estimate and of the
// ground truth.
#pragma once

#include "edvo/eval/align.hpp"
#include "edvo/eval/associate.hpp"
#include "edvo/eval/statistics.hpp"

#include <vector>

namespace edvo {

struct AteError {
  Stamp stamp;          // of the estimate
  double distance = 0;  // [m]
};

struct Ate {
  AlignmentKind alignment = AlignmentKind::kSe3;
  Similarity truth_from_estimate;
  Statistics distance;           // [m]
  std::vector<AteError> errors;  // one per match, in order of time
};

// Throws Error(kEvaluation) if there are too few matches to align.
[[nodiscard]] Ate absolute_trajectory_error(const Trajectory& truth, const Trajectory& estimate,
                                            const std::vector<Match>& matches,
                                            AlignmentKind alignment);

}  // namespace edvo
