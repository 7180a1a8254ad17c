// SPDX-License-Identifier: MIT
#include "edvo/eval/associate.hpp"

#include "edvo/core/associate.hpp"

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

std::vector<Match> associate_as_tum(const std::vector<double>& truth, std::vector<double> estimate,
                                    const AssociateOptions& options) {
  for (double& stamp : estimate) stamp += options.offset;
  std::vector<Match> matches;
  for (const auto& [i, j] : associate(truth, estimate, options.max_difference))
    matches.push_back({.truth = i, .estimate = j});
  return matches;
}

std::vector<Match> associate_as_evo(const std::vector<double>& truth,
                                    const std::vector<double>& estimate,
                                    const AssociateOptions& options) {
  const bool estimate_is_longer = estimate.size() > truth.size();
  const std::vector<double>& shorter = estimate_is_longer ? truth : estimate;
  const std::vector<double>& longer = estimate_is_longer ? estimate : truth;
  const double offset = estimate_is_longer ? options.offset : -options.offset;  // of the longer
  std::vector<Match> matches;
  for (std::size_t i = 0; i < shorter.size(); ++i) {
    const auto gap = [&](std::size_t j) { return std::abs(longer[j] + offset - shorter[i]); };
    const auto next = std::lower_bound(longer.begin(), longer.end(), shorter[i] - offset);
    std::size_t nearest =
        std::min(static_cast<std::size_t>(next - longer.begin()), longer.size() - 1);
    if (nearest > 0 && gap(nearest - 1) <= gap(nearest)) --nearest;
    if (gap(nearest) > options.max_difference) continue;
    matches.push_back(estimate_is_longer ? Match{.truth = i, .estimate = nearest}
                                         : Match{.truth = nearest, .estimate = i});
  }
  return matches;
}

}  // namespace

std::vector<double> script_stamps(const Trajectory& trajectory) {
  std::vector<double> stamps;
  stamps.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) stamps.push_back(script_seconds(pose.stamp));
  return stamps;
}

std::vector<Match> associate(const Trajectory& truth, const Trajectory& estimate,
                             const AssociateOptions& options) {
  if (truth.empty() || estimate.empty()) return {};
  const std::vector<double> truth_stamps = script_stamps(truth);
  const std::vector<double> estimate_stamps = script_stamps(estimate);
  switch (options.protocol) {
    case Protocol::kTum:
      return associate_as_tum(truth_stamps, estimate_stamps, options);
    case Protocol::kEvo:
      return associate_as_evo(truth_stamps, estimate_stamps, options);
  }
  return {};
}

}  // namespace edvo
