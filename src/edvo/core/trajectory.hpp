// SPDX-License-Identifier: MIT
// A trajectory: poses in time.
#pragma once

#include "edvo/core/se3.hpp"
#include "edvo/core/stamp.hpp"

#include <vector>

namespace edvo {

struct StampedPose {
  Stamp stamp;
  SE3 world_from_camera;
  int segment = 0;  // the motion between poses of different segments is not known
};

using Trajectory = std::vector<StampedPose>;  // ordered by stamp

// Sum of the distances from pose to pose [m].
[[nodiscard]] double path_length(const Trajectory& trajectory);

}  // namespace edvo
