// SPDX-License-Identifier: MIT
// The inner loops of direct alignment: photometric and point-to-plane residuals of all points and
// their normal equations.
#pragma once

#include "edvo/core/se3.hpp"
#include "edvo/track/reference.hpp"
#include "edvo/track/robust.hpp"

#include <Eigen/Core>
#include <vector>

namespace edvo {

// The pose of a frame and its brightness: I_current = gain * I_reference + bias.
struct Alignment {
  SE3 cur_from_ref;
  double gain = 1;
  double bias = 0;  // [grey levels]
};

constexpr float kIntensityUnit = 64.F;  // [grey levels] makes gain and bias steps of like size
constexpr float kInlierSigmas = 3.F;
constexpr float kNearest = 0.05F;  // [m] a point nearer to the camera is not in view

// Sums over points: J' W J (upper triangle), J' W r and the robust cost. Unknowns: xi, gain,
// bias / kIntensityUnit.
struct PhotometricSums {
  Eigen::Matrix<double, 8, 8> hessian = Eigen::Matrix<double, 8, 8>::Zero();
  Eigen::Matrix<double, 8, 1> gradient = Eigen::Matrix<double, 8, 1>::Zero();
  double cost = 0;
};

// Residuals I_current(pi(T p)) - gain I_reference - bias of every point [grey levels]; NaN where
// out of view, and behind the last point up to a multiple of kLanes.
void photometric_residuals(const ReferenceLevel& reference, const Level& current,
                           const Alignment& alignment, std::vector<float>& residuals);

// sigma: of the residuals [grey levels]. Points out of view pay the loss of kInlierSigmas:
// otherwise the best pose is one that sees nothing.
[[nodiscard]] PhotometricSums sum_photometric(const ReferenceLevel& reference,
                                              const std::vector<float>& residuals, double gain,
                                              float sigma, Loss loss, float loss_parameter);

// Sums over residuals of the pose alone, upper triangle of the Hessian of xi.
struct PoseSums {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double cost = 0;
};

// Residuals n . (ref_from_cur x_cur) - 1, x_cur the point that the sensor saw where the reference
// point projects to: a share of depth, so its sigma is that of inverse depth times depth.
// depth: H x W of the camera, [m], NaN = none. noise: sigma of inverse depth [1 / m].
[[nodiscard]] PoseSums sum_surface(const SurfacePoints& surface, const Camera& camera,
                                   const cv::Mat_<float>& depth, const SE3& cur_from_ref,
                                   float noise, float weight);

// Sigma of those residuals as one of inverse depth [1 / m], from their median; 0 without any.
// errors: room to work in.
[[nodiscard]] float surface_sigma(const SurfacePoints& surface, const Camera& camera,
                                  const cv::Mat_<float>& depth, const SE3& cur_from_ref,
                                  std::vector<float>& errors);

}  // namespace edvo
