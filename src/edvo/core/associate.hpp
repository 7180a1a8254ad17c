// SPDX-License-Identifier: MIT
// Which stamps of two series belong together: the rule of the TUM tools' associate.py.
#pragma once

#include "edvo/core/stamp.hpp"

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace edvo {

struct IndexPair {
  std::size_t first = 0, second = 0;  // into the two series
};

// A stamp as the scripts hold it: a double, as if read from its text [s]. Which of two equal gaps
// is the smaller one, and whether 20 ms are less than 0.02 s, is decided there by rounding; the
// same pairs and the same digits need the same rounding.
[[nodiscard]] double script_seconds(const Stamp& stamp);

// Pairs closer than largest_gap [s], taken greedily from the smallest gap on, each stamp once;
// returned in the order of the first series. Both series are strictly ordered [s]. Throws
// Error(kInput) where a stamp has more than most_candidates on average.
[[nodiscard]] std::vector<IndexPair> associate(
    std::span<const double> first, std::span<const double> second, double largest_gap,
    std::size_t most_candidates = std::numeric_limits<std::size_t>::max());

// The smallest distance of any two stamps of the two series, not empty. [s]
[[nodiscard]] double smallest_gap(std::span<const Stamp> first, std::span<const Stamp> second);

}  // namespace edvo
