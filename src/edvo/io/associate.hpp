// SPDX-License-Identifier: MIT
// Which stamps of two series belong together: the rule of the TUM tools' associate.py.
#pragma once

#include "edvo/core/stamp.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace edvo {

struct IndexPair {
  std::size_t first = 0, second = 0;  // into the two series
};

// Pairs closer than largest_gap [s], taken greedily from the smallest gap on, each stamp once;
// returned in the order of the first series. Both series are strictly ordered. Throws
// Error(kInput) where a stamp has hundreds of candidates: such stamps are not in seconds.
[[nodiscard]] std::vector<IndexPair> associate(std::span<const Stamp> first,
                                               std::span<const Stamp> second, double largest_gap);

// The smallest distance of any two stamps of the two series, not empty. [s]
[[nodiscard]] double smallest_gap(std::span<const Stamp> first, std::span<const Stamp> second);

}  // namespace edvo
