// SPDX-License-Identifier: MIT
// The rigid motion or similarity that best maps one set of points to another (Horn 1987, Umeyama
// 1991).
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/core/trajectory.hpp"

#include <Eigen/Core>

namespace edvo {

enum class AlignmentKind {
  kNone,  // no alignment
  kSe3,   // rotation and translation
  kSim3,  // and scale, for cameras without metric scale
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

// Minimizes the sum of squared distances between target and similarity * source, both 3 x N [m];
// equal columns correspond. Always a proper rotation, also where the points do not determine it (a
// line, a single place); scale stays 1 if the source does not move. Throws Error(kEvaluation) for
// fewer than three points unless alignment is kNone.
[[nodiscard]] Similarity align(const Eigen::Matrix3Xd& target, const Eigen::Matrix3Xd& source,
                               AlignmentKind alignment);

[[nodiscard]] inline Eigen::Vector3d operator*(const Similarity& a, const Eigen::Vector3d& point) {
  return a.motion * Eigen::Vector3d(a.scale * point);
}

// The poses expressed in the target frame; positions are scaled.
[[nodiscard]] Trajectory transformed(const Similarity& target_from_source,
                                     const Trajectory& trajectory);

}  // namespace edvo
