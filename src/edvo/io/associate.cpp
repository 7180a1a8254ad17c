// SPDX-License-Identifier: MIT
#include "edvo/io/associate.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

namespace edvo {
namespace {

constexpr std::size_t kMostCandidatesPerStamp = 200;  // a 5 kHz camera at a gap of 20 ms

struct Candidate {
  double gap = 0;  // [s]
  IndexPair pair;
};

// As the script holds them. Which of two equal gaps is the smaller one, and whether 20 ms are less
// than 0.02 s, is decided there by the rounding of doubles; the same pairs need the same rounding.
std::vector<double> in_seconds(std::span<const Stamp> stamps) {
  std::vector<double> seconds;
  for (const Stamp& stamp : stamps) {
    const std::string text = to_string(stamp);
    std::from_chars(text.data(), text.data() + text.size(), seconds.emplace_back());
  }
  return seconds;
}

std::vector<Candidate> candidates_within(const std::vector<double>& first,
                                         const std::vector<double>& second, double largest_gap) {
  std::vector<Candidate> candidates;
  const std::size_t most =
      kMostCandidatesPerStamp * std::max<std::size_t>({first.size(), second.size(), 1});
  std::size_t begin = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    while (begin < second.size() && first[i] - second[begin] >= largest_gap) ++begin;
    for (std::size_t j = begin; j < second.size() && second[j] - first[i] < largest_gap; ++j)
      candidates.push_back(
          {.gap = std::abs(first[i] - second[j]), .pair = {.first = i, .second = j}});
    if (candidates.size() > most)
      throw Error(ErrorCode::kInput,
                  fmt::format("time stamps around {:.9f} are too close for an association within "
                              "{} s; are they in seconds?",
                              first[i], largest_gap));
  }
  return candidates;
}

}  // namespace

std::vector<IndexPair> associate(std::span<const Stamp> first, std::span<const Stamp> second,
                                 double largest_gap) {
  std::vector<Candidate> candidates =
      candidates_within(in_seconds(first), in_seconds(second), largest_gap);
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
