// SPDX-License-Identifier: MIT
#include "edvo/eval/evaluate.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>

#include <cmath>

namespace edvo {
namespace {

constexpr std::size_t kFewestToAlign = 3;
constexpr double kLargestGap = 1;  // poses further apart in time say nothing about each other [s]
constexpr double kStandstill = 0.01;  // a path shorter than this is the noise of ground truth [m]

void check(const EvalOptions& options) {
  const double gap = options.association.max_difference;
  if (!(gap > 0 && gap <= kLargestGap))
    throw Error(
        ErrorCode::kUsage,
        fmt::format("max-diff must be above 0 s and at most {} s, got {}", kLargestGap, gap));
  if (!std::isfinite(options.association.offset))
    throw Error(ErrorCode::kUsage, "offset must be a finite number of seconds");
  if (options.rpe.max_pairs < 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("max-pairs must not be negative, got {}", options.rpe.max_pairs));
  if (options.frames < 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("frames must not be negative, got {}", options.frames));
}

std::string time_range(const Trajectory& trajectory) {
  if (trajectory.empty()) return "nothing";
  return fmt::format("{} .. {}", to_string(trajectory.front().stamp),
                     to_string(trajectory.back().stamp));
}

void require_enough(const std::vector<Match>& matches, const Trajectory& truth,
                    const Trajectory& estimate, const EvalOptions& options) {
  const std::size_t needed = options.alignment == AlignmentKind::kNone ? 1 : kFewestToAlign;
  if (matches.size() >= needed) return;
  throw Error(ErrorCode::kEvaluation,
              fmt::format("{} of {} poses have ground truth within {} s, at least {} needed: "
                          "estimate covers {} s, ground truth {} s; are they of the same "
                          "sequence, or do their clocks differ (--offset)?",
                          matches.size(), estimate.size(), options.association.max_difference,
                          needed, time_range(estimate), time_range(truth)));
}

Trajectory scaled(Trajectory trajectory, double scale) {
  for (StampedPose& pose : trajectory) pose.world_from_camera.translation *= scale;
  return trajectory;
}

Drift final_drift(const Trajectory& truth, const Trajectory& estimate,
                  const std::vector<Match>& matches) {
  const auto moved = [&](const Trajectory& trajectory, std::size_t Match::*index) {
    return inverse(trajectory[matches.front().*index].world_from_camera) *
           trajectory[matches.back().*index].world_from_camera;
  };
  Drift drift;
  drift.distance =
      (moved(truth, &Match::truth).translation - moved(estimate, &Match::estimate).translation)
          .norm();
  for (std::size_t i = 1; i < matches.size(); ++i)
    drift.path_length += (truth[matches[i].truth].world_from_camera.translation -
                          truth[matches[i - 1].truth].world_from_camera.translation)
                             .norm();
  if (drift.path_length > kStandstill) drift.percent = 100.0 * drift.distance / drift.path_length;
  return drift;
}

std::vector<std::string> warnings_about(const Evaluation& evaluation) {
  std::vector<std::string> warnings;
  const std::string delta = to_string(evaluation.options.rpe.delta);
  if (!evaluation.rpe) {
    warnings.push_back(fmt::format("no two poses are {} apart: no RPE", delta));
  } else if (evaluation.rpe->void_pairs > 0 &&
             evaluation.options.rpe.delta.unit != DeltaUnit::kAllPairs) {
    warnings.push_back(fmt::format(
        "{} of {} RPE pairs join a pose with itself, as no other is near {} later: RPE is too "
        "good; choose a larger delta",
        evaluation.rpe->void_pairs, evaluation.rpe->errors.size(), delta));
  }
  return warnings;
}

}  // namespace

Evaluation evaluate(const Trajectory& truth, const Trajectory& estimate,
                    const EvalOptions& options) {
  check(options);
  Evaluation evaluation;
  evaluation.options = options;
  evaluation.poses = estimate.size();
  evaluation.matches = associate(truth, estimate, options.association);
  const std::vector<Match>& matches = evaluation.matches;
  require_enough(matches, truth, estimate, options);

  evaluation.seconds = seconds_between(estimate[matches.front().estimate].stamp,
                                       estimate[matches.back().estimate].stamp);
  evaluation.coverage = options.frames > 0 ? static_cast<double>(estimate.size()) / options.frames
                                           : static_cast<double>(matches.size()) /
                                                 static_cast<double>(estimate.size());
  evaluation.ate = absolute_trajectory_error(truth, estimate, matches, options.alignment);
  const Trajectory sized = scaled(estimate, evaluation.ate.truth_from_estimate.scale);
  evaluation.rpe = relative_pose_error(truth, sized, options.association, options.rpe);
  evaluation.drift = final_drift(truth, sized, matches);
  evaluation.warnings = warnings_about(evaluation);
  return evaluation;
}

std::string describe_protocol(const EvalOptions& options) {
  const bool tum = options.association.protocol == Protocol::kTum;
  std::string alignment = "not aligned";
  if (options.alignment == AlignmentKind::kSe3) alignment = "SE(3)-aligned";
  if (options.alignment == AlignmentKind::kSim3) alignment = "Sim(3)-aligned";
  std::string offset;
  if (options.association.offset != 0)
    offset = fmt::format(", offset {} s", options.association.offset);
  std::string delta = "any two poses";
  if (options.rpe.delta.unit != DeltaUnit::kAllPairs)
    delta = fmt::format("fixed delta {}", to_string(options.rpe.delta));
  return fmt::format("{} protocol: ATE rmse over pairs {} {} s apart{}, {}; RPE rmse over {}",
                     tum ? "TUM" : "evo", tum ? "<" : "<=", options.association.max_difference,
                     offset, alignment, delta);
}

std::string describe_coverage(const EvalOptions& options) {
  if (options.frames > 0) return fmt::format("estimated poses / {} frames", options.frames);
  return "poses with ground truth / estimated poses";
}

}  // namespace edvo
