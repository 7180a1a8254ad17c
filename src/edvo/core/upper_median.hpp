// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>

namespace edvo {

// The middle of the values, which it reorders; the upper one of an even number. Needs one at least.
template <typename Values>
[[nodiscard]] auto upper_median(Values& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace edvo
