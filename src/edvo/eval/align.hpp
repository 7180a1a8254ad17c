// SPDX-License-Identifier: MIT
// The motion that lays one set of points best on another (Horn 1987, Umeyama 1991).
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/core/trajectory.hpp"

#include <Eigen/Core>

namespace edvo {

enum class AlignmentKind {
  kNone,  // the estimate stays where it is
  kSe3,   // rotation and translation
  kSim3,  // and scale, for cameras that cannot know it
};

template <>
struct EnumNames<AlignmentKind> {
  static constexpr auto names = std::to_array<std::pair<AlignmentKind, std::string_view>>({
      {AlignmentKind::kNone, "none"},
      {AlignmentKind::kSe3, "se3"},
      {AlignmentKind::kSim3, "sim3"},
  });
};

// x_target = scale * rotation * x_source + translation.
struct Similarity {
  double scale = 1;
  SE3 motion;  // rotation and translation, applied after the scale
};

// Minimizes the sum of squared distances between target and similarity * source. Columns belong
// together. Always a proper rotation, also where the points leave it open (a line, a single place);
// scale stays 1 where the source does not move. Throws Error(kEvaluation) below three points unless
// alignment is kNone.
[[nodiscard]] Similarity align(const Eigen::Matrix3Xd& target, const Eigen::Matrix3Xd& source,
                               AlignmentKind alignment);

[[nodiscard]] inline Eigen::Vector3d operator*(const Similarity& a, const Eigen::Vector3d& point) {
  return a.motion * Eigen::Vector3d(a.scale * point);
}

// The poses as seen from the target.
[[nodiscard]] Trajectory transformed(const Similarity& target_from_source,
                                     const Trajectory& trajectory);

}  // namespace edvo
