// SPDX-License-Identifier: MIT
// Where a robot may drive: a map of cells seen from above.
#pragma once

#include "edvo/core/se3.hpp"

#include <cstdint>
#include <opencv2/core.hpp>

namespace edvo {

enum class CellState : std::uint8_t { kUnknown, kFree, kOccupied };

struct OccupancyGrid {
  double resolution = 0;                             // side of a cell [m]
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // of cell (0, 0)'s corner, in the grid [m]
  cv::Mat_<std::uint8_t> cells;                      // CellState; row: y / resolution
  SE3 grid_from_map;                                 // z up, the floor at z = 0
};

}  // namespace edvo
