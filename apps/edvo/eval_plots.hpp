// SPDX-License-Identifier: MIT
// Evaluations as plots.
#pragma once

#include "eval_tables.hpp"

#include "edvo/report/plot.hpp"

#include <span>

namespace edvo::app {

// The aligned estimates over the ground truth, seen along the axis in which it extends least.
[[nodiscard]] Plot trajectory_plot(const Trajectory& truth,
                                   std::span<const NamedEvaluation> evaluations);

// Errors over time, counted from the first matched pose of all.
[[nodiscard]] Plot ate_plot(std::span<const NamedEvaluation> evaluations);
[[nodiscard]] Plot rpe_translation_plot(std::span<const NamedEvaluation> evaluations);
[[nodiscard]] Plot rpe_rotation_plot(std::span<const NamedEvaluation> evaluations);

}  // namespace edvo::app
