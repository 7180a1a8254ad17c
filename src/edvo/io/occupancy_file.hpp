// SPDX-License-Identifier: MIT
// Occupancy grids as ROS's map_server reads them: an image and a YAML file beside it.
#pragma once

#include "edvo/core/occupancy_grid.hpp"

#include <filesystem>

namespace edvo {

// file: a PGM (0 = occupied, 254 = free, 205 = not known); the YAML file has the same name but for
// its ending. Throws Error(kOutput) and leaves an existing file as it was if it cannot be written.
void write_occupancy(const std::filesystem::path& file, const OccupancyGrid& grid);

}  // namespace edvo
