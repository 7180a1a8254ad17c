// SPDX-License-Identifier: MIT
#include "edvo/run/outcome.hpp"

#include <fmt/core.h>

namespace edvo {

void add_to(FrameCounts& counts, const FrameResult& result) {
  if (is_tracked(result.status)) ++counts.tracked;
  if (result.status == FrameStatus::kLost) ++counts.lost;
  if (result.status == FrameStatus::kRestarted) ++counts.restarted;
}

std::int64_t frames_processed(const FrameCounts& counts) {
  return counts.tracked + counts.lost + counts.restarted;
}

std::int64_t frames_due(const FrameCounts& counts) {
  return frames_processed(counts) + counts.skipped;
}

std::optional<Error> failure_of(const RunOutcome& outcome, const std::string& source) {
  if (outcome.error) return outcome.error;
  const FrameCounts& counts = outcome.counts;
  const std::int64_t due = frames_due(counts);
  // One pose is where the world begins, not a motion that was tracked.
  const bool has_tracked = counts.tracked > 1 || (counts.tracked == 1 && due == 1);
  if (has_tracked || outcome.interrupted) return std::nullopt;
  return Error(ErrorCode::kTrackingLost,
               fmt::format("{}: none of {} frames could be tracked ({} lost, {} skipped)", source,
                           due, counts.lost, counts.skipped));
}

}  // namespace edvo
