// SPDX-License-Identifier: MIT
#include "edvo/io/associate.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace edvo {
namespace {

constexpr std::size_t kMostCandidatesPerStamp = 200;  // a 5 kHz camera at a gap of 20 ms

struct Candidate {
  std::int64_t gap = 0;  // [ns]
  IndexPair pair;
};

std::vector<Candidate> candidates_within(std::span<const Stamp> first,
                                         std::span<const Stamp> second, std::int64_t largest_gap) {
  std::vector<Candidate> candidates;
  const std::size_t most =
      kMostCandidatesPerStamp * std::max<std::size_t>({first.size(), second.size(), 1});
  std::size_t begin = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    while (begin < second.size() && first[i].nanoseconds - second[begin].nanoseconds >= largest_gap)
      ++begin;
    for (std::size_t j = begin; j < second.size(); ++j) {
      const std::int64_t difference = second[j].nanoseconds - first[i].nanoseconds;
      if (difference >= largest_gap) break;
      candidates.push_back({.gap = std::abs(difference), .pair = {.first = i, .second = j}});
    }
    if (candidates.size() > most)
      throw Error(ErrorCode::kInput,
                  fmt::format("stamps around {} are too close for an association within {} s; are "
                              "they in seconds?",
                              to_string(first[i]), static_cast<double>(largest_gap) * 1e-9));
  }
  return candidates;
}

}  // namespace

std::vector<IndexPair> associate(std::span<const Stamp> first, std::span<const Stamp> second,
                                 double largest_gap) {
  std::vector<Candidate> candidates =
      candidates_within(first, second, static_cast<std::int64_t>(std::llround(largest_gap * 1e9)));
  std::ranges::sort(candidates, {}, [](const Candidate& c) {
    return std::tuple(c.gap, c.pair.first, c.pair.second);
  });
  std::vector<bool> first_taken(first.size(), false), second_taken(second.size(), false);
  std::vector<IndexPair> pairs;
  for (const Candidate& candidate : candidates) {
    const auto [i, j] = candidate.pair;
    if (first_taken[i] || second_taken[j]) continue;
    first_taken[i] = second_taken[j] = true;
    pairs.push_back(candidate.pair);
  }
  std::ranges::sort(pairs, {}, &IndexPair::first);
  return pairs;
}

double smallest_gap(std::span<const Stamp> first, std::span<const Stamp> second) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Stamp& stamp : first) {
    const auto next = std::ranges::lower_bound(second, stamp);
    if (next != second.end()) smallest = std::min(smallest, seconds_between(stamp, *next));
    if (next != second.begin())
      smallest = std::min(smallest, seconds_between(*std::prev(next), stamp));
  }
  return smallest;
}

}  // namespace edvo
