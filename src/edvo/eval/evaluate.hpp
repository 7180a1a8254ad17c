// SPDX-License-Identifier: MIT
// Compares an estimate with ground truth: ATE, RPE, drift and coverage in one call.
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

// Position error at the end after the first matched poses have been aligned.
struct Drift {
  double distance = 0;            // [m]
  double path_length = 0;         // of the ground truth at the matched poses [m]
  std::optional<double> percent;  // of that path; none if the ground truth does not move
};

struct Evaluation {
  EvalOptions options;
  std::size_t poses = 0;       // in the estimate
  std::vector<Match> matches;  // its poses with ground truth
  double seconds = 0;          // from the first match to the last
  double coverage = 0;         // [0..1], see describe_coverage()
  Ate ate;
  std::optional<Rpe> rpe;  // none if no two poses are delta apart
  Drift drift;
  std::vector<std::string> warnings;
};

// Throws Error(kUsage) for impossible options, Error(kEvaluation) if no pose or too few have ground
// truth. With kSim3 the scale found for the ATE is also applied for RPE and drift.
[[nodiscard]] Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate,
                                  const EvalOptions& options = {});

// One line to print beside every number: which poses, how they are aligned, over which delta.
[[nodiscard]] std::string describe_protocol(const EvalOptions& options);

// What coverage is a share of: the frames if their number is known, else the estimate's poses.
[[nodiscard]] std::string describe_coverage(const EvalOptions& options);

}  // namespace edvo
