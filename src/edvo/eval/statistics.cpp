// SPDX-License-Identifier: MIT
#include "edvo/eval/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace edvo {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

Statistics statistics(const std::vector<double>& values) {
  if (values.empty()) return {};
  double sum = 0, sum_of_squares = 0, sum_of_deviations = 0;
  for (const double value : values) {
    sum += value;
    sum_of_squares += value * value;
  }
  const double count = static_cast<double>(values.size());
  const double mean = sum / count;
  for (const double value : values) sum_of_deviations += (value - mean) * (value - mean);
  const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
  return {.rmse = std::sqrt(sum_of_squares / count),
          .mean = mean,
          .median = median(values),
          .std = std::sqrt(sum_of_deviations / count),
          .min = *smallest,
          .max = *largest};
}

}  // namespace edvo
