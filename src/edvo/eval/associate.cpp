// SPDX-License-Identifier: MIT
#include "edvo/eval/associate.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace edvo {
namespace {

struct Candidate {
  double gap = 0;  // [s]
  Match match;
};

// All pairs closer than max_difference. Both lists ascend, so a window moves along.
std::vector<Candidate> close_pairs(const std::vector<double>& truth,
                                   const std::vector<double>& estimate,
                                   const AssociateOptions& options) {
  std::vector<Candidate> pairs;
  std::size_t window = 0;
  for (std::size_t j = 0; j < estimate.size(); ++j) {
    const double stamp = estimate[j] + options.offset;
    while (window < truth.size() && stamp - truth[window] >= options.max_difference) ++window;
    for (std::size_t i = window; i < truth.size(); ++i) {
      const double gap = std::abs(truth[i] - stamp);
      if (gap < options.max_difference) {
        pairs.push_back({.gap = gap, .match = {.truth = i, .estimate = j}});
      } else if (truth[i] > stamp) {
        break;
      }
    }
  }
  return pairs;
}

std::vector<Match> associate_as_tum(const std::vector<double>& truth,
                                    const std::vector<double>& estimate,
                                    const AssociateOptions& options) {
  std::vector<Candidate> pairs = close_pairs(truth, estimate, options);
  std::sort(pairs.begin(), pairs.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.gap, a.match.truth, a.match.estimate) <
           std::tie(b.gap, b.match.truth, b.match.estimate);
  });
  std::vector<bool> truth_taken(truth.size(), false), estimate_taken(estimate.size(), false);
  std::vector<Match> matches;
  for (const auto& [gap, match] : pairs) {
    if (truth_taken[match.truth] || estimate_taken[match.estimate]) continue;
    truth_taken[match.truth] = estimate_taken[match.estimate] = true;
    matches.push_back(match);
  }
  std::sort(matches.begin(), matches.end(),
            [](const Match& a, const Match& b) { return a.truth < b.truth; });
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

// Correctly rounded from the whole and the fractional part, as the text's conversion would be.
double script_stamp(const Stamp& stamp) {
  constexpr std::int64_t kSecond = 1'000'000'000;  // [ns]
  return static_cast<double>(stamp.nanoseconds / kSecond) +
         static_cast<double>(stamp.nanoseconds % kSecond) / static_cast<double>(kSecond);
}

}  // namespace

std::vector<double> script_stamps(const Trajectory& trajectory) {
  std::vector<double> stamps;
  stamps.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) stamps.push_back(script_stamp(pose.stamp));
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
