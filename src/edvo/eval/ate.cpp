// SPDX-License-Identifier: MIT
#include "edvo/eval/ate.hpp"

namespace edvo {

Ate absolute_trajectory_error(const Trajectory& truth, const Trajectory& estimate,
                              const std::vector<Match>& matches, AlignmentKind alignment) {
  Eigen::Matrix3Xd target(3, matches.size()), source(3, matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    target.col(i) = truth[matches[i].truth].world_from_camera.translation;
    source.col(i) = estimate[matches[i].estimate].world_from_camera.translation;
  }
  Ate ate{.alignment = alignment,
          .truth_from_estimate = align(target, source, alignment),
          .distance = {},
          .errors = {}};
  std::vector<double> distances;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Eigen::Vector3d moved = ate.truth_from_estimate * Eigen::Vector3d(source.col(i));
    distances.push_back((moved - target.col(i)).norm());
    ate.errors.push_back(
        {.stamp = estimate[matches[i].estimate].stamp, .distance = distances.back()});
  }
  ate.distance = statistics(distances);
  return ate;
}

}  // namespace edvo
