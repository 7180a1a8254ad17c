// SPDX-License-Identifier: MIT
// Shi-Tomasi corner optimization of an edge image (paper, section III-B, eq. 1-3, fig. 3).
#pragma once

#include "edvo/core/fields.hpp"

#include <concepts>
#include <opencv2/core.hpp>
#include <vector>

namespace edvo {

// visit_fields lists the options of the program; the other fields are constants
// (docs/experiments/options.md).
struct CornerOptions {
  bool enabled = true;
  double quality = 0.05;        // tau_c as a share of the strongest response [0..1]
  double window_sigma = 1.5;    // [px]
  int window = 20;              // [px]
  int crowded = 4;              // corners
  int budget = 2;               // corners
  double strict_quality = 0.2;  // [0..1]
  double min_distance = 8;      // [px]
  int disc_radius = 2;          // [px]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, CornerOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("enabled", self.enabled, Range{}, "corner optimization on or off (ablation)");
  visit("quality", self.quality, Range{0, 1},
        "tau_c of eq. 3 as a share of the strongest response [0..1]");
  visit("window", self.window, Range{4, 200}, "side and stride of the counting windows [px]");
  visit("crowded", self.crowded, Range{0, 10000},
        "a window with more corners is cleared and extracted again");
  visit("disc_radius", self.disc_radius, Range{0, 50}, "radius of the disc around a corner [px]");
}

struct Corner {
  cv::Point position;  // [px]
  float response = 0;  // min(lambda_1, lambda_2), eq. 3
};

// R = min(lambda_1, lambda_2) of the structure tensor with a Gaussian window. image: H x W, 255
// = 1.
[[nodiscard]] cv::Mat_<float> min_eigenvalue(const cv::Mat_<std::uint8_t>& image,
                                             double window_sigma);

// Local maxima of the response above tau_c, thinned where they crowd; in row order.
// edges: H x W, 255 = edge.
[[nodiscard]] std::vector<Corner> optimize_corners(const cv::Mat_<std::uint8_t>& edges,
                                                   const CornerOptions& options);

// H x W, 255 within the discs.
[[nodiscard]] cv::Mat_<std::uint8_t> draw_discs(cv::Size size, const std::vector<Corner>& corners,
                                                int radius);

// Edges and the discs of the optimized corners (paper, fig. 3).
[[nodiscard]] cv::Mat_<std::uint8_t> with_corner_discs(const cv::Mat_<std::uint8_t>& edges,
                                                       const CornerOptions& options);

}  // namespace edvo
