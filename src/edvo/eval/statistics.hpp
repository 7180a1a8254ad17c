// SPDX-License-Identifier: MIT
// Statistics of a set of errors.
#pragma once

#include <vector>

namespace edvo {

// In the unit of the values; std is the population's. All zero where there are no values.
struct Statistics {
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0;
};

[[nodiscard]] Statistics statistics(const std::vector<double>& values);

// For an even number of values the mean of the middle two; 0 for no values.
[[nodiscard]] double median(std::vector<double> values);

}  // namespace edvo
