// SPDX-License-Identifier: MIT
#include "edvo/track/robust.hpp"

#include <algorithm>

namespace edvo {

float mad_sigma(std::vector<float>& residuals) {
  if (residuals.empty()) return 0;
  constexpr float kSigmaPerMad = 1.4826F;  // of a normal distribution
  for (float& r : residuals) r = std::abs(r);
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return kSigmaPerMad * *middle;
}

}  // namespace edvo
