// SPDX-License-Identifier: MIT
// The plots of the report page.
#pragma once

#include "edvo/report/summary.hpp"

#include <array>
#include <string>
#include <string_view>

namespace edvo {

// One per stage of kStages.
inline constexpr std::array<std::string_view, 6> kStageColors = {"#56b4e9", "#009e73", "#8fce9f",
                                                                 "#e69f00", "#0072b2", "#cc79a7"};

// Maps, errors, tracking quality and times, each a figure with its caption.
[[nodiscard]] std::string plots_of(const RunSummary& summary, const RunLog& log,
                                   const RunOutcome& outcome);

// The same trajectories in space.
[[nodiscard]] std::string space_of(const RunSummary& summary, const RunLog& log,
                                   const RunOutcome& outcome);

// Where the camera was when, thinned, for the script of the page: a JSON array of
// [s since the first frame, frame, x, y, z].
[[nodiscard]] std::string route_of(const RunLog& log, const Trajectory& trajectory);

}  // namespace edvo
