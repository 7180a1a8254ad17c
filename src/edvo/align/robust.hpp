// SPDX-License-Identifier: MIT
// Robust losses over residuals in units of their sigma. Cost is rho(r), IRLS weight rho'(r) / r.
#pragma once

#include "edvo/core/fields.hpp"

#include <cmath>
#include <span>

namespace edvo {

enum class Loss { kHuber, kStudent, kTukey };

template <>
struct EnumNames<Loss> {
  static constexpr auto names = std::to_array<std::pair<Loss, std::string_view>>(
      {{Loss::kHuber, "huber"}, {Loss::kStudent, "student"}, {Loss::kTukey, "tukey"}});
};

struct RobustValue {
  float cost = 0;    // rho(r)
  float weight = 0;  // rho'(r) / r
};

// k: Huber's theta_H (Eq. 6), Tukey's cut-off, or Student's degrees of freedom.
[[nodiscard]] inline RobustValue robust(Loss loss, float k, float r) {
  switch (loss) {
    case Loss::kHuber: {
      const float a = std::abs(r);
      return a <= k ? RobustValue{0.5F * r * r, 1.F} : RobustValue{k * (a - 0.5F * k), k / a};
    }
    case Loss::kStudent: {
      const float s = 1.F + r * r / k;
      return {0.5F * (k + 1.F) * std::log(s), (k + 1.F) / (k * s)};
    }
    case Loss::kTukey: {
      const float u = 1.F - r * r / (k * k);
      if (u <= 0.F) return {k * k / 6.F, 0.F};
      return {k * k / 6.F * (1.F - u * u * u), u * u};
    }
  }
  return {};
}

// Sigma of the residuals by their median absolute deviation from zero: 1.4826 median |r|, to one
// part in 10,000. NaN is left out; 0 for none.
[[nodiscard]] float mad_sigma(std::span<const float> residuals);

}  // namespace edvo
