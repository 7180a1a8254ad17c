// SPDX-License-Identifier: MIT
// The inner loops of direct alignment: photometric residuals of all points and their normal
// equations.
#pragma once

#include "edvo/align/brightness.hpp"
#include "edvo/align/point_range.hpp"
#include "edvo/align/reference.hpp"
#include "edvo/align/robust.hpp"
#include "edvo/core/se3.hpp"

#include <Eigen/Core>
#include <vector>

namespace edvo {

// The pose of a frame and its brightness: I_current = gain * I_reference + bias.
struct Alignment {
  SE3 cur_from_ref;
  double gain = 1;
  double bias = 0;  // [grey levels]
};

constexpr float kInlierSigmas = 3.F;

// Sums over points: J' W J (upper triangle), J' W r and the robust cost. Unknowns: xi, gain,
// bias / kBrightnessUnit.
struct PhotometricSums {
  Eigen::Matrix<double, 8, 8> hessian = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> gradient = Eigen::Matrix<double, 8, 1>::Zero();
  double cost = 0;

  PhotometricSums& operator+=(const PhotometricSums& other) {
    hessian += other.hessian;
    gradient += other.gradient;
    cost += other.cost;
    return *this;
  }
};

// Residuals I_current(pi(T p)) - gain I_reference - bias of every point [grey levels]; NaN where
// out of view, and behind the last point up to a multiple of kLanes. current, readout: of a frame.
void photometric_residuals(const ReferenceLevel& reference, const Level& current,
                           const Vector6d& readout, const Alignment& alignment,
                           std::vector<float>& residuals);

// The robust cost alone, as below.
[[nodiscard]] double photometric_cost(const ReferenceLevel& reference,
                                      const std::vector<float>& residuals, float sigma, Loss loss,
                                      float loss_parameter);

// sigma: of the residuals [grey levels]. Points out of view pay the loss of kInlierSigmas:
// otherwise the best pose is one that sees nothing.
[[nodiscard]] PhotometricSums sum_photometric(const ReferenceLevel& reference,
                                              const std::vector<float>& residuals, PointRange range,
                                              double gain, float sigma, Loss loss,
                                              float loss_parameter);

}  // namespace edvo
