// SPDX-License-Identifier: MIT
#include "edvo/run/evaluation.hpp"

#include "edvo/eval/evaluate.hpp"
#include "edvo/io/depth_scale.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

// A curve is interrupted where it knows nothing for longer than this. [s]
constexpr double kLongestStep = 0.5;

void add_point(Curve& curve, double seconds, double value) {
  if (!curve.seconds.empty() && seconds - curve.seconds.back() > kLongestStep) {
    curve.seconds.push_back(curve.seconds.back());
    curve.values.push_back(std::numeric_limits<double>::quiet_NaN());
  }
  curve.seconds.push_back(seconds);
  curve.values.push_back(value);
}

TrajectoryErrors errors_from(const Evaluation& evaluation, const Stamp& start) {
  const Statistics& ate = evaluation.ate.distance;
  TrajectoryErrors errors{.ate = ate.rmse,
                          .ate_median = ate.median,
                          .ate_max = ate.max,
                          .drift = evaluation.drift.percent,
                          .ate_pairs = static_cast<std::int64_t>(evaluation.matches.size())};
  for (const AteError& error : evaluation.ate.errors)
    add_point(errors.ate_curve, seconds_between(start, error.stamp), error.distance);
  if (!evaluation.rpe) return errors;
  // Pairs of a pose with itself have no error: the protocol counts some, but all are no result.
  if (evaluation.rpe->void_pairs == evaluation.rpe->errors.size()) return errors;
  errors.rpe_translation = evaluation.rpe->translation.rmse;
  errors.rpe_rotation = evaluation.rpe->rotation.rmse;
  errors.rpe_pairs = static_cast<std::int64_t>(evaluation.rpe->errors.size());
  std::vector<RpeError> pairs = evaluation.rpe->errors;
  std::sort(pairs.begin(), pairs.end(),
            [](const RpeError& a, const RpeError& b) { return a.from < b.from; });
  for (const RpeError& pair : pairs) {
    const double middle =
        0.5 * (seconds_between(start, pair.from) + seconds_between(start, pair.to));
    add_point(errors.rpe_translation_curve, middle, pair.translation);
    add_point(errors.rpe_rotation_curve, middle, pair.rotation);
  }
  return errors;
}

// The ground truth while the run lasted, as seen from the estimate's world. With what the first and
// the last pose are compared with, even if it is a little before or after them.
Trajectory aligned_truth(const Trajectory& truth, const Trajectory& estimate,
                         const SE3& truth_from_estimate) {
  const double margin = AssociateOptions{}.max_difference;  // [s]
  const SE3 estimate_from_truth = inverse(truth_from_estimate);
  Trajectory aligned;
  for (const StampedPose& pose : truth)
    if (seconds_between(pose.stamp, estimate.front().stamp) < margin &&
        seconds_between(estimate.back().stamp, pose.stamp) < margin)
      aligned.push_back({pose.stamp, estimate_from_truth * pose.world_from_camera});
  return aligned;
}

}  // namespace

RunEvaluation evaluate_run(const GroundTruth& truth, const RunOutcome& outcome) {
  EvalOptions options;
  options.frames = static_cast<int>(frames_due(outcome.counts));
  const Evaluation final_poses = evaluate(truth.trajectory, outcome.trajectory, options);
  const Evaluation online_poses = evaluate(truth.trajectory, outcome.online, options);
  const Stamp start = outcome.first_stamp;
  const Ate scaled = absolute_trajectory_error(truth.trajectory, outcome.trajectory,
                                               final_poses.matches, AlignmentKind::kSim3);
  return {.ground_truth = truth.source,
          .protocol = describe_protocol(options),
          .final_poses = errors_from(final_poses, start),
          .online_poses = errors_from(online_poses, start),
          .truth = aligned_truth(truth.trajectory, outcome.trajectory,
                                 final_poses.ate.truth_from_estimate.motion),
          .scale = scaled.truth_from_estimate.scale,
          .scaled_ate = scaled.distance.rmse,
          .warnings = final_poses.warnings};
}

std::optional<std::string> warn_of_scale(const RunEvaluation& evaluation,
                                         const SourceInfo& source) {
  constexpr double kExplained = 0.5;  // of the error
  const double scale = evaluation.scale;
  const bool is_off = std::abs(scale - 1) > kScaleTolerance && scale > 0 &&
                      evaluation.scaled_ate < kExplained * evaluation.final_poses.ate;
  if (!is_off || source.depth_scale <= 0) return std::nullopt;
  const double wanted = source.depth_scale / scale;
  const double usual = nearest_usual_scale(wanted);
  return fmt::format(
      "the motion must be scaled by {:.4g} to fit the ground truth (ATE {:.4g} m instead of {:.4g} "
      "m): the depth scale is probably wrong ({}; try --depth-scale {:.6g}), or depth is not "
      "registered to colour",
      scale, evaluation.scaled_ate, evaluation.final_poses.ate, source.depth_origin,
      usual == source.depth_scale ? wanted : usual);
}

}  // namespace edvo
