// SPDX-License-Identifier: MIT
#include "edvo/run/outcome.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace edvo {
namespace {

// "; of 12: hardly a pixel has a depth in range", or nothing.
std::string most_frequent_cause(const FrameCounts& counts) {
  const auto most =
      std::max_element(counts.causes.begin(), counts.causes.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most == counts.causes.end()) return "";
  return fmt::format("; {} of them because {}", most->second, explain(most->first));
}

}  // namespace

void add_to(FrameCounts& counts, const FrameResult& result) {
  if (is_tracked(result.status)) ++counts.tracked;
  if (result.status == FrameStatus::kRelocalized) ++counts.relocalized;
  if (result.status == FrameStatus::kRestarted) ++counts.restarted;
  if (result.status == FrameStatus::kLost) {
    ++counts.lost;
    ++counts.causes[result.loss_cause];
  } else {
    counts.segments = std::max<std::int64_t>(counts.segments, result.segment + 1);
  }
}

std::int64_t frames_processed(const FrameCounts& counts) {
  return counts.tracked + counts.lost + counts.restarted;
}

std::int64_t frames_due(const FrameCounts& counts) {
  return frames_processed(counts) + counts.skipped;
}

std::string explain(LossCause cause) {
  switch (cause) {
    case LossCause::kNone:
      break;
    case LossCause::kNoDepth:
      return "hardly a pixel has a depth in range; is the depth scale right?";
    case LossCause::kConstantDepth:
      return "all depths of an image are the same: no sensor measures that";
    case LossCause::kNoTexture:
      return "hardly a pixel has a gradient";
    case LossCause::kFewPoints:
      return "too few pixels have both depth and gradient";
    case LossCause::kUnlike:
      return "the images do not look alike";
    case LossCause::kOverlap:
      return "too few of the keyframe's points are in view";
    case LossCause::kOutliers:
      return "too few of the points in view fit";
    case LossCause::kResiduals:
      return "residuals are far larger than usual";
    case LossCause::kTooFast:
      return "the motion would be faster than any camera moves";
    case LossCause::kTwoMotions:
      return "two motions explain the images, and nothing tells which is the camera's";
  }
  return "no cause is known";
}

std::optional<Error> failure_of(const RunOutcome& outcome, const std::string& source) {
  if (outcome.error) return outcome.error;
  const FrameCounts& counts = outcome.counts;
  const std::int64_t due = frames_due(counts);
  // One pose is where the world begins, not a motion that was tracked.
  const bool has_tracked = counts.tracked > 1 || (counts.tracked == 1 && due == 1);
  if (has_tracked || outcome.interrupted) return std::nullopt;
  return Error(ErrorCode::kTrackingLost,
               fmt::format("{}: none of {} frames could be tracked ({} lost, {} skipped){}", source,
                           due, counts.lost, counts.skipped, most_frequent_cause(counts)));
}

}  // namespace edvo
