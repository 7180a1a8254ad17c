// SPDX-License-Identifier: MIT
// Evaluations as tables, JSON, plots, and as the evo commands that compute the same.
#pragma once

#include "edvo/eval/evaluate.hpp"
#include "edvo/report/plot.hpp"
#include "edvo/report/table.hpp"

#include <span>
#include <string>

namespace edvo {

// One estimate beside its ground truth.
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

// The aligned estimates over the ground truth, seen along the axis in which it extends least.
[[nodiscard]] Plot trajectory_plot(const Trajectory& truth,
                                   std::span<const NamedEvaluation> evaluations);

// Errors over time, counted from the first matched pose of all.
[[nodiscard]] Plot ate_plot(std::span<const NamedEvaluation> evaluations);
[[nodiscard]] Plot rpe_translation_plot(std::span<const NamedEvaluation> evaluations);
[[nodiscard]] Plot rpe_rotation_plot(std::span<const NamedEvaluation> evaluations);

// Shell commands, one line each, for the same or the nearest figures with evo. evo knows no delta
// in seconds: it is given as frames of the estimate's median interval.
[[nodiscard]] std::vector<std::string> evo_commands(const std::string& truth_file,
                                                    const NamedEvaluation& evaluation);

}  // namespace edvo
