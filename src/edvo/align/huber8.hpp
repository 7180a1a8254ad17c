// SPDX-License-Identifier: MIT
// Huber's loss of eight residuals at a time, as robust() has it for one.
#pragma once

#include "edvo/simd/float8.hpp"

namespace edvo {

// residual: in units of its sigma. k: theta_H (Eq. 6).
struct Huber8 {
  simd::Float8 cost;    // rho(r)
  simd::Float8 weight;  // rho'(r) / r

  [[gnu::always_inline]] Huber8(const simd::Float8& residual, float k) {
    const simd::Float8 limit = simd::Float8{} + k;
    const simd::Float8 size = residual < 0.F ? -residual : residual;
    const simd::Float8 inlier = size < k ? size : limit;
    cost = inlier * (size - 0.5F * inlier);
    weight = k / (size > k ? size : limit);
  }
};

}  // namespace edvo
