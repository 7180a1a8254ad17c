// SPDX-License-Identifier: MIT
#include "edvo/synth/path.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <cstddef>

namespace edvo::synth {
namespace {

constexpr double kSigma = 0.05;         // [s] keeps a hand's tremor up to about 5 Hz
constexpr double kReach = 3 * kSigma;   // [s] poses farther away count for nothing
constexpr std::size_t kLeastPoses = 7;  // within reach: fewer are no measurement of jitter

// Where a parabola through the motion around a pose has it, by least squares with weights that
// fall with the time from it. The pose is number `at` of `recorded`, its neighbours `first` to
// `last`, the latter excluded.
SE3 on_parabola(const Trajectory& recorded, std::size_t first, std::size_t at, std::size_t last) {
  const StampedPose& here = recorded[at];
  const SE3 camera_from_world = inverse(here.world_from_camera);
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 6> products = Eigen::Matrix<double, 3, 6>::Zero();
  for (std::size_t i = first; i < last; ++i) {
    const double t = seconds_between(here.stamp, recorded[i].stamp) / kSigma;
    const Eigen::Vector3d powers(1, t, t * t);
    const double weight = std::exp(-0.5 * t * t);
    squares += weight * powers * powers.transpose();
    products +=
        weight * powers * log(camera_from_world * recorded[i].world_from_camera).transpose();
  }
  const Eigen::Matrix<double, 3, 6> parabola = squares.ldlt().solve(products);
  const Vector6d shift = parabola.row(0).transpose();
  return shift.allFinite() ? here.world_from_camera * exp(shift) : here.world_from_camera;
}

}  // namespace

Trajectory without_jitter(const Trajectory& recorded) {
  Trajectory smooth = recorded;
  std::size_t first = 0, last = 0;
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    while (seconds_between(recorded[first].stamp, recorded[i].stamp) > kReach) ++first;
    while (last < recorded.size() &&
           seconds_between(recorded[i].stamp, recorded[last].stamp) <= kReach)
      ++last;
    if (last - first >= kLeastPoses)
      smooth[i].world_from_camera = on_parabola(recorded, first, i, last);
  }
  return smooth;
}

}  // namespace edvo::synth
