// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/core/se3.hpp"

namespace edvo {

// Sums over residuals of the pose alone, upper triangle of the Hessian of xi.
struct PoseSums {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0;

  PoseSums& operator+=(const PoseSums& other) {
    hessian += other.hessian;
    gradient += other.gradient;
    cost += other.cost;
    return *this;
  }
};

}  // namespace edvo
