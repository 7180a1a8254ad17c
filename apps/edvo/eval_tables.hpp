// SPDX-License-Identifier: MIT
// Evaluations as a table, as JSON, and as the evo commands for the same.
#pragma once

#include "edvo/eval/evaluate.hpp"
#include "edvo/report/table.hpp"

#include <span>
#include <string>
#include <vector>

namespace edvo::app {

// One estimate, compared with the ground truth.
struct NamedEvaluation {
  std::string name;     // in tables and legends
  std::string file;     // where it was read from
  Trajectory estimate;  // as read
  Evaluation evaluation;
};

// A row each. All must have been evaluated with the same options, those that the header tells.
[[nodiscard]] Table evaluation_table(std::span<const NamedEvaluation> evaluations);

// One object, indented: protocol, ground truth, and all statistics of each estimate.
[[nodiscard]] std::string evaluation_json(const std::string& truth_file, const Trajectory& truth,
                                          std::span<const NamedEvaluation> evaluations);

// Shell commands for the same or the nearest figures. evo knows no delta in seconds: it is given as
// frames of the estimate's median interval.
[[nodiscard]] std::vector<std::string> evo_commands(const std::string& truth_file,
                                                    const std::string& estimate_file,
                                                    const Trajectory& estimate,
                                                    const EvalOptions& options);

}  // namespace edvo::app
