// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/core/se3.hpp"

namespace edvo {

// A rolling shutter reads one row after the other while the camera moves (docs/adr/0013): the row
// at a share s of the height, -1/2 to 1/2, is seen from world_from_camera * exp(s readout()).
struct RollingShutter {
  Vector6d velocity = Vector6d::Zero();  // (rho [m/s], phi [rad/s]) in the camera's own frame
  double readout_seconds = 0;            // from the first row to the last; 0 = all rows at once
  [[nodiscard]] Vector6d readout() const { return readout_seconds * velocity; }
};

}  // namespace edvo
