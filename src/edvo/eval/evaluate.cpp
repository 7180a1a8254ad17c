// SPDX-License-Identifier: MIT
#include "edvo/eval/evaluate.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

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

// Of stamps in another unit than seconds: how often one lasts as long as the other.
std::string_view hint_of_unit(const Trajectory& truth, const Trajectory& estimate) {
  if (truth.empty() || estimate.empty()) return "";
  const double truth_length = seconds_between(truth.front().stamp, truth.back().stamp);
  const double length = seconds_between(estimate.front().stamp, estimate.back().stamp);
  const auto is_about = [](double ratio, double factor) {
    return ratio > factor / 3 && ratio < factor * 3;
  };
  if (is_about(length / truth_length, 1e3))
    return " If the estimate's stamps are milliseconds, divide them by 1000.";
  if (is_about(truth_length / length, 1e3))
    return " If the ground truth's stamps are milliseconds, divide them by 1000.";
  return "";
}

void require_enough(const std::vector<Match>& matches, const Trajectory& truth,
                    const Trajectory& estimate, const EvalOptions& options) {
  const std::size_t needed = options.alignment == AlignmentKind::kNone ? 1 : kFewestToAlign;
  if (matches.size() >= needed) return;
  throw Error(
      ErrorCode::kEvaluation,
      fmt::format("{} of {} poses have ground truth within {} s, at least {} needed: "
                  "estimate covers {} s, ground truth {} s; are they of the same "
                  "sequence, or do their clocks differ (--offset)?{}",
                  matches.size(), estimate.size(), options.association.max_difference, needed,
                  time_range(estimate), time_range(truth), hint_of_unit(truth, estimate)));
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

// As it would be if the file had qw first and was read with qw last.
Eigen::Quaterniond reread(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

using Rotation = Eigen::Quaterniond (*)(const Eigen::Quaterniond&);

// Root mean square of how wrong the rotations since the first match are. [rad]
double rotation_error(const Trajectory& truth, const Trajectory& estimate,
                      const std::vector<Match>& matches, Rotation truth_as, Rotation estimate_as) {
  const auto turned = [](const Trajectory& trajectory, std::size_t first, std::size_t now,
                         Rotation as) {
    return Eigen::Quaterniond(as(trajectory[first].world_from_camera.rotation).conjugate() *
                              as(trajectory[now].world_from_camera.rotation));
  };
  double sum = 0;
  for (const Match& match : matches) {
    const double angle = turned(truth, matches.front().truth, match.truth, truth_as)
                             .angularDistance(turned(estimate, matches.front().estimate,
                                                     match.estimate, estimate_as));
    sum += angle * angle;
  }
  return std::sqrt(sum / static_cast<double>(matches.size()));
}

// Which of both was written with qw first, though it was read with qw last; empty if neither.
std::string_view with_w_first(const Trajectory& truth, const Trajectory& estimate,
                              const std::vector<Match>& matches) {
  constexpr double kSuspicious = 0.03;  // [rad]
  constexpr double kMuchBetter = 0.1;   // of the error as read
  const Rotation as_read = [](const Eigen::Quaterniond& q) { return q; };
  const double error = rotation_error(truth, estimate, matches, as_read, as_read);
  if (error < kSuspicious) return {};
  const auto is_better = [&](Rotation truth_as, Rotation estimate_as) {
    return rotation_error(truth, estimate, matches, truth_as, estimate_as) < kMuchBetter * error;
  };
  if (is_better(as_read, reread)) return "the estimate's";
  if (is_better(reread, as_read)) return "the ground truth's";
  return {};
}

// More poses than frames cover no more than all of them; warnings_about() says so.
double coverage_of(const Evaluation& evaluation) {
  const auto poses = static_cast<double>(evaluation.poses);
  if (evaluation.options.frames > 0) return std::min(1.0, poses / evaluation.options.frames);
  return static_cast<double>(evaluation.matches.size()) / poses;
}

std::size_t segment_count(const Trajectory& trajectory) {
  std::set<int> segments;
  for (const StampedPose& pose : trajectory) segments.insert(pose.segment);
  return segments.size();
}

std::vector<std::string> warnings_about(const Evaluation& evaluation, const Trajectory& estimate) {
  std::vector<std::string> warnings;
  const EvalOptions& options = evaluation.options;
  if (options.frames > 0 && evaluation.poses > static_cast<std::size_t>(options.frames))
    warnings.push_back(
        fmt::format("{} poses of {} frames: coverage says 100 %, but is the number "
                    "of frames right?",
                    evaluation.poses, options.frames));
  if (const std::size_t segments = segment_count(estimate); segments > 1)
    warnings.push_back(
        fmt::format("the poses are in {} segments, between which no motion is "
                    "known; the errors take them as one",
                    segments));
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
  evaluation.coverage = coverage_of(evaluation);
  evaluation.ate = absolute_trajectory_error(truth, estimate, matches, options.alignment);
  const Trajectory sized = scaled(estimate, evaluation.ate.truth_from_estimate.scale);
  evaluation.rpe = relative_pose_error(truth, sized, options.association, options.rpe);
  evaluation.drift = final_drift(truth, sized, matches);
  evaluation.warnings = warnings_about(evaluation, estimate);
  const std::string_view swapped = with_w_first(truth, estimate, matches);
  if (!swapped.empty())
    evaluation.warnings.push_back(fmt::format(
        "the rotations fit if {} quaternions have qw first; expected qx qy qz qw", swapped));
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
