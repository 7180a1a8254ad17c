// SPDX-License-Identifier: MIT
#include "edvo/core/trajectory.hpp"

namespace edvo {

double path_length(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length += (trajectory[i].world_from_camera.translation -
               trajectory[i - 1].world_from_camera.translation)
                  .norm();
  return length;
}

}  // namespace edvo
