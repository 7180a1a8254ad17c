// SPDX-License-Identifier: MIT
#include "edvo/eval/align.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <Eigen/SVD>

#include <cassert>

namespace edvo {
namespace {

constexpr Eigen::Index kFewestPoints = 3;
constexpr double kStandstill = 1e-9;  // spread of the last written decimal: no scale in it [m]

}  // namespace

Similarity align(const Eigen::Matrix3Xd& target, const Eigen::Matrix3Xd& source,
                 AlignmentKind alignment) {
  assert(target.cols() == source.cols());
  if (alignment == AlignmentKind::kNone) return {};
  if (source.cols() < kFewestPoints)
    throw Error(ErrorCode::kEvaluation,
                fmt::format("alignment needs at least {} pairs of poses, got {}", kFewestPoints,
                            source.cols()));
  const Eigen::Vector3d target_mean = target.rowwise().mean();
  const Eigen::Vector3d source_mean = source.rowwise().mean();
  const Eigen::Matrix3Xd target_centred = target.colwise() - target_mean;
  const Eigen::Matrix3Xd source_centred = source.colwise() - source_mean;
  const Eigen::Matrix3d covariance = target_centred * source_centred.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Turning the weakest direction round costs least where U V^T would be a reflection.
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs.z() = -1;
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();

  Similarity similarity;
  const double squared_spread = source_centred.squaredNorm();
  const double count = static_cast<double>(source.cols());
  if (alignment == AlignmentKind::kSim3 && squared_spread > count * kStandstill * kStandstill)
    similarity.scale = svd.singularValues().dot(signs) / squared_spread;
  similarity.motion = {.rotation = Eigen::Quaterniond(rotation).normalized(),
                       .translation = target_mean - similarity.scale * (rotation * source_mean)};
  return similarity;
}

Trajectory transformed(const Similarity& target_from_source, const Trajectory& trajectory) {
  Trajectory moved = trajectory;
  for (StampedPose& pose : moved) {
    pose.world_from_camera.translation *= target_from_source.scale;
    pose.world_from_camera = target_from_source.motion * pose.world_from_camera;
  }
  return moved;
}

}  // namespace edvo
