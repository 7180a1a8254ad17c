// SPDX-License-Identifier: MIT
// Which pixels of a keyframe are tracked, and where they lie in space.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/image/frame.hpp"

#include <Eigen/Core>
#include <concepts>
#include <vector>

namespace edvo {

// visit_fields lists the options of the program; the other fields are constants
// (docs/experiments/options.md).
struct SelectOptions {
  int max_points = 4000;
  int min_points = 50;
  int cell = 8;               // [px]
  double min_gradient = 3.0;  // [grey levels / px]
  double min_depth = 0.1;     // [m]
  double max_depth = 8.0;     // [m]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, SelectOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("max_points", self.max_points, Range{10, 1e7}, "points kept of a keyframe, spread evenly");
  visit("min_gradient", self.min_gradient, Range{0, 255},
        "least gradient of a tracked pixel [grey levels / px]");
  visit("min_depth", self.min_depth, Range{0, 100}, "nearest depth that is trusted [m]");
  visit("max_depth", self.max_depth, Range{0, 100}, "farthest depth that is trusted [m]");
}

struct SelectedPixel {
  cv::Point pixel;     // level 0
  float depth = 0;     // [m]
  float gradient = 0;  // magnitude [grey levels / px]
};

// Pixels of the mask with gradient and a depth that is that of the nearest surface there
// (edge_depth.hpp), at most max_points, the strongest of each cell first; in row order. mask: H x W
// of level 0, 255 = candidate.
[[nodiscard]] std::vector<SelectedPixel> select_pixels(const Frame& frame,
                                                       const cv::Mat_<std::uint8_t>& mask,
                                                       const cv::Mat_<std::uint8_t>& valid,
                                                       const SelectOptions& options);

// Every step-th pixel of every step-th row that has a trusted depth: for coarse alignment of whole
// images. recycled: of no more use, its memory serves the new ones.
[[nodiscard]] std::vector<SelectedPixel> grid_pixels(const Frame& frame, int step,
                                                     const SelectOptions& options,
                                                     std::vector<SelectedPixel> recycled = {});

// At most `limit` of them: the strongest of every cell, then the second of every cell, and so on.
// In the order given. width: of the image [px].
[[nodiscard]] std::vector<SelectedPixel> spread(const std::vector<SelectedPixel>& pixels, int width,
                                                int cell, int limit);

}  // namespace edvo
