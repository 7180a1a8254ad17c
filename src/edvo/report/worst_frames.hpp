// SPDX-License-Identifier: MIT
// The frames of a run that one looks at first.
#pragma once

#include "edvo/report/summary.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace edvo {

inline constexpr std::size_t kWorstFrames = 5;  // at most

// Of the candidates (indices in the input): first the beginnings of losses, the longest ahead;
// then, with ground truth, by the relative error around the frame, else by residuals against the
// usual ones. Two frames of the same moment count as one. Each says in one line why it is among
// them; the pictures are left to the caller.
[[nodiscard]] std::vector<WorstFrame> choose_worst_frames(
    const RunLog& log, const std::optional<RunEvaluation>& evaluation,
    std::span<const std::int64_t> candidates);

}  // namespace edvo
