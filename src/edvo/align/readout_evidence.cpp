// SPDX-License-Identifier: MIT
#include "edvo/align/readout_evidence.hpp"

#include "edvo/align/warp.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace edvo {
namespace {

constexpr int kUnknowns = 9;       // xi, gain, bias, the readout time
constexpr std::size_t kEvery = 3;  // points: many frames are to tell
constexpr float kDegrees = 2.F;    // of freedom, of Student's loss

Eigen::Vector3f velocity_of(const Vector6d& twist, const Eigen::Vector3f& point) {
  return twist.head<3>().cast<float>() + twist.tail<3>().cast<float>().cross(point);
}

}  // namespace

ReadoutEvidence readout_evidence(const Reference& reference, const Frame& frame,
                                 const AlignResult& result, const AlignOptions& options,
                                 AlignScratch& scratch) {
  const ReferenceLevel& points = reference.levels[static_cast<std::size_t>(options.finest_level)];
  const Level& level = frame.levels[static_cast<std::size_t>(options.finest_level)];
  photometric_residuals(points, level, frame.shutter.readout(), result.alignment,
                        scratch.residuals);
  const SE3& pose = result.alignment.cur_from_ref;
  const Eigen::Matrix3f R = pose.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = pose.translation.cast<float>();
  const Pinhole camera = pinhole(level.camera);
  const float rows = static_cast<float>(level.camera.height);
  const auto share = [&](const Eigen::Vector3f& p) {
    return (camera.fy * p.y() / p.z() + camera.cy) / rows - 0.5F;
  };
  const float inverse_sigma = 1.F / static_cast<float>(result.sigma);
  Eigen::Matrix<double, kUnknowns, kUnknowns> hessian =
      Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Eigen::Matrix<double, kUnknowns, 1> gradient = Eigen::Matrix<double, kUnknowns, 1>::Zero();
  for (std::size_t i = 0; i < points.count; i += kEvery) {
    const float r = scratch.residuals[i];
    if (std::isnan(r)) continue;
    const Eigen::Vector3f p(points.x[i], points.y[i], points.z[i]);
    const Eigen::Vector3f q = R * p + t;
    const Eigen::Vector3f moved =
        share(p) * velocity_of(reference.velocity, p) -
        R.transpose() * (share(q) * velocity_of(frame.shutter.velocity, q));
    const float s = r * inverse_sigma;
    const float weight =
        points.weight[i] * inverse_sigma * inverse_sigma * (kDegrees + 1) / (kDegrees + s * s);
    Eigen::Matrix<float, kUnknowns, 1> J;
    for (std::size_t k = 0; k < 6; ++k) J[static_cast<int>(k)] = points.jacobian[k][i];
    J[6] = -points.intensity[i];
    J[7] = -1;
    J[8] = J.head<3>().dot(moved);
    hessian.selfadjointView<Eigen::Upper>().rankUpdate(J.cast<double>(),
                                                       static_cast<double>(weight));
    gradient += static_cast<double>(weight * r) * J.cast<double>();
  }
  hessian = hessian.selfadjointView<Eigen::Upper>();
  const Eigen::Matrix<double, 8, 1> cross = hessian.topRightCorner<8, 1>();
  const Eigen::LDLT<Eigen::Matrix<double, 8, 8>> rest(hessian.topLeftCorner<8, 8>());
  const double information = hessian(8, 8) - cross.dot(rest.solve(cross));
  const double slope = gradient[8] - cross.dot(rest.solve(gradient.head<8>()));
  if (!(information > 0) || !std::isfinite(slope)) return {};
  return {.seconds = frame.shutter.readout_seconds - slope / information,
          .information = information};
}

}  // namespace edvo
