// SPDX-License-Identifier: MIT
#include "edvo/eval/rpe.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace edvo {
namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;
constexpr double kTruthIntervals = 2;  // how far the nearest ground truth may be [its intervals]

struct IndexPair {
  std::size_t from = 0, to = 0;
};

// The original's search. On equal distance the value that bisection meets first wins, so a plain
// lower_bound would not give the same pairs.
std::size_t nearest(const std::vector<double>& ascending, double value) {
  std::size_t best = 0, begin = 0, end = ascending.size();
  double smallest = std::abs(ascending[0] - value);
  while (begin < end) {
    const std::size_t middle = (begin + end) / 2;
    const double distance = std::abs(ascending[middle] - value);
    if (distance < smallest) {
      smallest = distance;
      best = middle;
    }
    if (ascending[middle] == value) return middle;
    if (ascending[middle] > value) {
      end = middle;
    } else {
      begin = middle + 1;
    }
  }
  return best;
}

SE3 relative_motion(const Trajectory& trajectory, std::size_t from, std::size_t to) {
  return inverse(trajectory[from].world_from_camera) * trajectory[to].world_from_camera;
}

// Where each pose stands on the scale in which delta is measured.
std::vector<double> positions_along(const Trajectory& trajectory, DeltaUnit unit) {
  if (unit == DeltaUnit::kSeconds) return script_stamps(trajectory);
  std::vector<double> positions = {0};
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    double step = 1;  // frames
    const SE3 motion = relative_motion(trajectory, i - 1, i);
    if (unit == DeltaUnit::kMetres) step = motion.translation.norm();
    if (unit == DeltaUnit::kRadians) step = rotation_angle(motion);
    if (unit == DeltaUnit::kDegrees) step = rotation_angle(motion) * kDegreesPerRadian;
    positions.push_back(positions.back() + step);
  }
  return positions;
}

// Unlike std::uniform_int_distribution the same with every compiler; its bias is below 1e-12.
std::size_t random_index(std::mt19937_64& engine, std::size_t count) {
  return static_cast<std::size_t>(engine() % count);
}

std::vector<IndexPair> all_pairs(std::size_t poses, const RpeOptions& options) {
  std::vector<IndexPair> pairs;
  const auto limit = static_cast<std::size_t>(options.max_pairs);
  if (limit == 0 || poses * poses < limit) {
    for (std::size_t i = 0; i < poses; ++i)
      for (std::size_t j = 0; j < poses; ++j) pairs.push_back({i, j});
    return pairs;
  }
  std::mt19937_64 engine(options.seed);
  for (std::size_t n = 0; n < limit; ++n) {
    const std::size_t from = random_index(engine, poses);
    pairs.push_back({from, random_index(engine, poses)});
  }
  return pairs;
}

std::vector<IndexPair> pairs_at_delta(const Trajectory& estimate, const RpeOptions& options) {
  if (options.delta.unit == DeltaUnit::kAllPairs) return all_pairs(estimate.size(), options);
  const std::vector<double> positions = positions_along(estimate, options.delta.unit);
  std::vector<IndexPair> pairs;
  for (std::size_t from = 0; from < estimate.size(); ++from) {
    const std::size_t to = nearest(positions, positions[from] + options.delta.value);
    // The last pose is the nearest one of all that have none delta later.
    if (to + 1 != estimate.size()) pairs.push_back({from, to});
  }
  const auto limit = static_cast<std::size_t>(options.max_pairs);
  if (limit == 0 || pairs.size() <= limit) return pairs;
  std::mt19937_64 engine(options.seed);
  for (std::size_t n = 0; n < limit; ++n)
    std::swap(pairs[n], pairs[n + random_index(engine, pairs.size() - n)]);
  pairs.resize(limit);
  return pairs;
}

RpeError error_between(const SE3& truth, const SE3& estimate, const Stamp& from, const Stamp& to) {
  const SE3 error = inverse(truth) * estimate;
  return {.from = from,
          .to = to,
          .translation = error.translation.norm(),
          .rotation = rotation_angle(error) * kDegreesPerRadian};
}

double median_interval(const std::vector<double>& stamps) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  return median(intervals);
}

// The index of the ground truth pose of each pose of the estimate, where there is one.
std::vector<std::optional<std::size_t>> nearest_truth(const Trajectory& truth,
                                                      const Trajectory& estimate, double offset) {
  const std::vector<double> stamps = script_stamps(truth);
  const double farthest = kTruthIntervals * median_interval(stamps);
  std::vector<std::optional<std::size_t>> indices;
  for (const double stamp : script_stamps(estimate)) {
    const std::size_t i = nearest(stamps, stamp + offset);
    const bool close = std::abs(stamps[i] - (stamp + offset)) <= farthest;
    indices.push_back(close ? std::optional(i) : std::nullopt);
  }
  return indices;
}

std::vector<RpeError> errors_as_tum(const Trajectory& truth, const Trajectory& estimate,
                                    double offset, const RpeOptions& options) {
  const auto truth_of = nearest_truth(truth, estimate, offset);
  std::vector<RpeError> errors;
  for (const auto& [from, to] : pairs_at_delta(estimate, options)) {
    if (!truth_of[from] || !truth_of[to]) continue;
    // As the script takes it, from the later pose to the earlier one. The other way the error is
    // the same motion seen from the other end, and its translation differs in the third digit.
    errors.push_back(error_between(relative_motion(truth, *truth_of[to], *truth_of[from]),
                                   relative_motion(estimate, to, from), estimate[from].stamp,
                                   estimate[to].stamp));
  }
  return errors;
}

std::vector<RpeError> errors_as_evo(const Trajectory& truth, const Trajectory& estimate,
                                    const AssociateOptions& association, const Delta& delta) {
  if (delta.unit != DeltaUnit::kFrames || delta.value < 1 || delta.value != std::floor(delta.value))
    throw Error(ErrorCode::kUsage,
                fmt::format("the evo protocol takes whole frames as delta, as in 1f, not {}",
                            to_string(delta)));
  const std::vector<Match> matches = associate(truth, estimate, association);
  const auto step = static_cast<std::size_t>(std::min(delta.value, 1e9));
  std::vector<RpeError> errors;
  for (std::size_t i = 0; i + step < matches.size(); i += step) {
    const Match& from = matches[i];
    const Match& to = matches[i + step];
    errors.push_back(error_between(relative_motion(truth, from.truth, to.truth),
                                   relative_motion(estimate, from.estimate, to.estimate),
                                   estimate[from.estimate].stamp, estimate[to.estimate].stamp));
  }
  return errors;
}

}  // namespace

std::optional<Rpe> relative_pose_error(const Trajectory& truth, const Trajectory& estimate,
                                       const AssociateOptions& association,
                                       const RpeOptions& options) {
  if (truth.empty() || estimate.empty()) return std::nullopt;
  Rpe rpe{.options = options, .translation = {}, .rotation = {}, .errors = {}, .void_pairs = 0};
  rpe.errors = association.protocol == Protocol::kTum
                   ? errors_as_tum(truth, estimate, association.offset, options)
                   : errors_as_evo(truth, estimate, association, options.delta);
  if (rpe.errors.empty()) return std::nullopt;
  std::vector<double> translations, rotations;
  for (const RpeError& error : rpe.errors) {
    translations.push_back(error.translation);
    rotations.push_back(error.rotation);
    if (error.from == error.to) ++rpe.void_pairs;
  }
  rpe.translation = statistics(translations);
  rpe.rotation = statistics(rotations);
  return rpe;
}

}  // namespace edvo
