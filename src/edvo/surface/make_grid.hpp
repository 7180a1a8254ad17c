// SPDX-License-Identifier: MIT
// An occupancy grid from depth images.
#pragma once

#include "edvo/core/occupancy_grid.hpp"
#include "edvo/surface/floor.hpp"

#include <span>

namespace edvo {

struct GridOptions {
  double resolution = 0.05;  // [m]
  double lowest = 0.1;       // above the floor: what is lower can be driven over [m]
  double highest = 1.5;      // above the floor: what is higher can be driven under [m]
  double max_depth = 4;      // farther points are left out [m]
  int max_cells = 20'000'000;
};

// How many pixels there are to a metre at this depth.
[[nodiscard]] double ray_density(const DepthView& view, double depth);

// A cell is occupied where, at some height between lowest and highest, rays end in it in at least
// half of the views that see it at that height; free where it is seen down to the floor, and is
// passed at all heights that a camera above them looked at; else unknown. The map's first camera
// looks along x. Throws Error(kResources) if there would be more cells than allowed.
[[nodiscard]] OccupancyGrid make_grid(std::span<const DepthView> views, const Floor& floor,
                                      const GridOptions& options = {});

}  // namespace edvo
