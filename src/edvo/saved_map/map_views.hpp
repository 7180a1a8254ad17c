// SPDX-License-Identifier: MIT
// What the keyframes of a map measured, for surfaces and points.
#pragma once

#include "edvo/core/colored_point.hpp"
#include "edvo/saved_map/saved_map.hpp"
#include "edvo/surface/depth_view.hpp"

#include <vector>

namespace edvo {

// Of the keyframes of one segment whose images are kept, at half size. Grey where the map has no
// colour.
[[nodiscard]] std::vector<DepthView> depth_views(const SavedMap& map, int segment);

// The points that its keyframes are tracked by, in the frame of the segment [m].
[[nodiscard]] std::vector<ColoredPoint> colored_points(const SavedMap& map, int segment);

// That with most keyframes; of equals the first. 0 of an empty map.
[[nodiscard]] int largest_segment(const SavedMap& map);

}  // namespace edvo
