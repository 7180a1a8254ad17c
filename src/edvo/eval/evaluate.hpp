// SPDX-License-Identifier: MIT
// The whole comparison of an estimate with ground truth in one call.
#pragma once

#include "edvo/eval/ate.hpp"
#include "edvo/eval/rpe.hpp"

#include <optional>
#include <string>
#include <vector>

namespace edvo {

// The defaults are the protocol of the TUM benchmark, in which papers quote ATE and RPE.
struct EvalOptions {
  AssociateOptions association;
  AlignmentKind alignment = AlignmentKind::kSe3;
  RpeOptions rpe;
  int frames = 0;  // images that the estimate was made from, 0 = unknown
};

// How far the end is from where it should be, with the first matched poses laid on each other.
struct Drift {
  double distance = 0;            // [m]
  double path_length = 0;         // of the ground truth at the matched poses [m]
  std::optional<double> percent;  // of that path; none where the ground truth stands still
};

struct Evaluation {
  EvalOptions options;
  std::size_t poses = 0;       // in the estimate
  std::vector<Match> matches;  // its poses with ground truth
  double seconds = 0;          // from the first match to the last
  double coverage = 0;         // [0..1], see describe_coverage()
  Ate ate;
  std::optional<Rpe> rpe;  // none where no two poses are delta apart
  Drift drift;
  std::vector<std::string> warnings;
};

// Throws Error(kUsage) for impossible options, Error(kEvaluation) where no pose or too few have
// ground truth. With kSim3 the scale found for the ATE also goes into RPE and drift.
[[nodiscard]] Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate,
                                  const EvalOptions& options = {});

// One line that must stand beside every number: which poses, aligned how, over which delta.
[[nodiscard]] std::string describe_protocol(const EvalOptions& options);

// What coverage is a part of: the frames where their number is known, else the estimate's poses.
[[nodiscard]] std::string describe_coverage(const EvalOptions& options);

}  // namespace edvo
