// SPDX-License-Identifier: MIT
// Which way is up in a map, and where the floor is, as depth images tell it.
#pragma once

#include "edvo/surface/depth_view.hpp"

#include <optional>
#include <span>

namespace edvo {

struct Floor {
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();  // unit length, in the world
  double height = 0;                               // of the floor along up [m]
};

// up: where it is known. Otherwise that normal of surfaces on which most agree among those within
// 45 degrees of the mean direction to the images' top. The floor is the lowest large surface across
// it. None if there are no such surfaces.
[[nodiscard]] std::optional<Floor> find_floor(std::span<const DepthView> views,
                                              const std::optional<Eigen::Vector3d>& up);

}  // namespace edvo
