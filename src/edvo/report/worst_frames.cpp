// SPDX-License-Identifier: MIT
#include "edvo/report/worst_frames.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

constexpr double kLongestMoment = 1;  // [s]
constexpr double kShareOfRun = 0.1;   // a moment of a short run
constexpr double kAround = 0.25;      // a frame whose error is looked for [s]
constexpr double kCentimetres = 100;

struct NearbyError {
  double value = 0;     // over one second [m/s]
  double distance = 0;  // in time [s]
};

struct Ranked {
  const FrameRecord* frame = nullptr;
  std::int64_t lost_frames = 0;
  std::optional<NearbyError> error;
  double rms_ratio = 0;  // to the usual rms
};

std::int64_t lost_frames_from(const std::vector<FrameRecord>& frames,
                              std::vector<FrameRecord>::const_iterator first) {
  const auto end = std::find_if(first, frames.end(), [](const FrameRecord& frame) {
    return frame.status != FrameStatus::kLost;
  });
  return end - first;
}

// The largest value of a curve around a moment; none where the curve has a gap.
std::optional<NearbyError> largest_near(const Curve& curve, double seconds) {
  std::optional<NearbyError> largest;
  for (std::size_t i = 0; i < curve.seconds.size(); ++i) {
    const double distance = std::abs(curve.seconds[i] - seconds);
    if (distance > kAround || !std::isfinite(curve.values[i])) continue;
    const NearbyError error{curve.values[i], distance};
    if (!largest || error.value > largest->value ||
        (error.value == largest->value && distance < largest->distance))
      largest = error;
  }
  return largest;
}

double usual_rms(const std::vector<FrameRecord>& frames) {
  std::vector<double> values;
  for (const FrameRecord& frame : frames)
    if (frame.status == FrameStatus::kTracked && std::isfinite(frame.rms))
      values.push_back(frame.rms);
  return quantile(std::move(values), 0.5);
}

bool is_worse(const Ranked& a, const Ranked& b) {
  if (a.lost_frames != b.lost_frames) return a.lost_frames > b.lost_frames;
  if (a.error.has_value() != b.error.has_value()) return a.error.has_value();
  if (a.error && a.error->value != b.error->value) return a.error->value > b.error->value;
  if (a.error) return a.error->distance < b.error->distance;
  return a.rms_ratio > b.rms_ratio;
}

std::string reason_for(const Ranked& ranked, double usual) {
  const FrameRecord& frame = *ranked.frame;
  if (ranked.lost_frames > 0)
    return fmt::format("lost for {} frame{}: {}", ranked.lost_frames,
                       ranked.lost_frames == 1 ? "" : "s", explain(frame.loss_cause));
  constexpr double kPercent = 100;
  std::string reason(name_of(frame.status));
  if (ranked.error)
    reason += fmt::format(", relative error {:.2f} cm/s", kCentimetres * ranked.error->value);
  if (frame.status == FrameStatus::kTracked || frame.status == FrameStatus::kRelocalized)
    reason +=
        fmt::format(", rms {:.1f} (usual {:.1f}) grey levels, inliers {:.0f} %, overlap {:.0f} %",
                    frame.rms, usual, kPercent * frame.inlier_ratio, kPercent * frame.overlap);
  return reason;
}

}  // namespace

std::vector<WorstFrame> choose_worst_frames(const RunLog& log,
                                            const std::optional<RunEvaluation>& evaluation,
                                            std::span<const std::int64_t> candidates) {
  if (log.frames.empty()) return {};
  const Stamp start = log.frames.front().stamp;
  const double usual = usual_rms(log.frames);
  std::vector<Ranked> ranking;
  for (const std::int64_t index : candidates) {
    const auto at = std::ranges::lower_bound(log.frames, index, {}, &FrameRecord::index);
    if (at == log.frames.end() || at->index != index) continue;
    Ranked ranked{.frame = &*at, .lost_frames = lost_frames_from(log.frames, at)};
    if (evaluation)
      ranked.error = largest_near(evaluation->final_poses.rpe_translation_curve,
                                  seconds_between(start, at->stamp));
    if (usual > 0 && std::isfinite(at->rms)) ranked.rms_ratio = at->rms / usual;
    ranking.push_back(ranked);
  }
  std::ranges::stable_sort(ranking, is_worse);
  const double moment =
      std::min(kLongestMoment, kShareOfRun * seconds_between(start, log.frames.back().stamp));
  std::vector<WorstFrame> worst;
  for (const Ranked& ranked : ranking) {
    const double seconds = seconds_between(start, ranked.frame->stamp);
    const auto is_same_moment = [&](const WorstFrame& other) {
      return std::abs(other.seconds - seconds) < moment;
    };
    if (worst.size() == kWorstFrames) break;
    if (ranked.lost_frames == 0 && std::ranges::any_of(worst, is_same_moment)) continue;
    worst.push_back({.frame = ranked.frame->index,
                     .seconds = seconds,
                     .reason = reason_for(ranked, usual),
                     .picture = {}});
  }
  return worst;
}

}  // namespace edvo
