// SPDX-License-Identifier: MIT
// Pairs the stamps of two series by the rule of the TUM tools' associate.py.
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

// A stamp as a double [s], as if read from its text. The TUM scripts compute with doubles, whose
// rounding decides which of two equal gaps is smaller and whether 20 ms are less than 0.02 s. The
// same rounding is needed to get the same pairs and digits.
[[nodiscard]] double script_seconds(const Stamp& stamp);

// Pairs whose stamps differ by less than largest_gap [s]: the smallest gap is taken first, and each
// stamp is used at most once. Returned in the order of the first series. Both series [s] must be
// strictly increasing. Throws Error(kInput) if a stamp has more than most_candidates possible
// partners on average.
[[nodiscard]] std::vector<IndexPair> associate(
    std::span<const double> first, std::span<const double> second, double largest_gap,
    std::size_t most_candidates = std::numeric_limits<std::size_t>::max());

// The smallest distance of any two stamps of the two series, not empty. [s]
[[nodiscard]] double smallest_gap(std::span<const Stamp> first, std::span<const Stamp> second);

}  // namespace edvo
