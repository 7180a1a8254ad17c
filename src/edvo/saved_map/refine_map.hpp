// SPDX-License-Identifier: MIT
// The odometry's last refinement, of the keyframes of a saved map.
#pragma once

#include "edvo/odometry/config.hpp"
#include "edvo/saved_map/saved_map.hpp"

namespace edvo {

// Refines the keyframes of each segment jointly, on their pixels (refine_jointly). The first of
// each stays; those without images follow the one before them. The same for any number of threads.
void refine_map(SavedMap& map, const WindowOptions& window, int threads);

}  // namespace edvo
