// SPDX-License-Identifier: MIT
// How far the end is, by two steps (Aitken's extrapolation; in several dimensions as Kuettler and
// Wall 2008 use it). With the weights of a robust loss each Gauss-Newton step is about as much
// shorter than the one before: from two of them follows how many of the second lead to the end.
#pragma once

#include <algorithm>

namespace edvo {

constexpr double kMostToCome = 20;  // steps: as many or more, also of steps that grow

// Of a step, all that would follow and itself, in steps; at least 1. taken: times the last step was
// taken. Products of the last step with itself, of both, and of this one with itself, in the metric
// of the Hessian, in which unknowns of all units compare.
[[nodiscard]] inline double steps_to_come(double taken, double last_last, double last_this,
                                          double this_this) {
  if (last_this >= last_last) return kMostToCome;
  const double to_come = taken * (last_last - last_this) / (last_last - 2 * last_this + this_this);
  return to_come > 1 ? std::min(to_come, kMostToCome) : 1;  // 1 where it is not a number
}

// How many times to take a step at once. Twice as far gains nothing on a quadratic cost, and where
// the end is not in sight no more than the step is known.
[[nodiscard]] inline double steps_at_once(double to_come) {
  constexpr double kMostAtOnce = 1.9;
  return to_come < kMostToCome ? std::min(to_come, kMostAtOnce) : 1;
}

}  // namespace edvo
