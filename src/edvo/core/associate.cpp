// SPDX-License-Identifier: MIT
#include "edvo/core/associate.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

namespace edvo {
namespace {

struct Candidate {
  double gap = 0;  // [s]
  IndexPair pair;
};

std::vector<Candidate> candidates_within(std::span<const double> first,
                                         std::span<const double> second, double largest_gap,
                                         std::size_t most_candidates) {
  std::vector<Candidate> candidates;
  const std::size_t stamps = std::max<std::size_t>({first.size(), second.size(), 1});
  std::size_t begin = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    while (begin < second.size() && first[i] - second[begin] >= largest_gap) ++begin;
    for (std::size_t j = begin; j < second.size() && second[j] - first[i] < largest_gap; ++j)
      candidates.push_back(
          {.gap = std::abs(first[i] - second[j]), .pair = {.first = i, .second = j}});
    if (candidates.size() / stamps >= most_candidates)
      throw Error(ErrorCode::kInput,
                  fmt::format("time stamps around {:.9f} are too close for an association within "
                              "{} s; are they in seconds?",
                              first[i], largest_gap));
  }
  return candidates;
}

}  // namespace

// Correctly rounded from the whole and the fractional part, as the text's conversion would be.
double script_seconds(const Stamp& stamp) {
  constexpr std::int64_t kSecond = 1'000'000'000;  // [ns]
  return static_cast<double>(stamp.nanoseconds / kSecond) +
         static_cast<double>(stamp.nanoseconds % kSecond) / static_cast<double>(kSecond);
}

std::vector<IndexPair> associate(std::span<const double> first, std::span<const double> second,
                                 double largest_gap, std::size_t most_candidates) {
  std::vector<Candidate> candidates =
      candidates_within(first, second, largest_gap, most_candidates);
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
