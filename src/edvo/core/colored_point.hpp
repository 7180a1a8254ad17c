// SPDX-License-Identifier: MIT
// A point with its colour.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace edvo {

struct ColoredPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  // in the frame that its owner says [m]
  std::array<std::uint8_t, 3> rgb = {0, 0, 0};
};

}  // namespace edvo
