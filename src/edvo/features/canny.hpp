// SPDX-License-Identifier: MIT
// Canny edges with thresholds taken from the image itself.
#pragma once

#include "edvo/core/fields.hpp"

#include <concepts>
#include <opencv2/core.hpp>

namespace edvo {

// visit_fields lists the options of the program; the other fields are constants
// (docs/experiments/options.md).
struct CannyOptions {
  double edge_share = 0.20;  // [0..1]
  double low_ratio = 0.4;    // [0..1]
  double blur_sigma = 1.0;   // [px]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, CannyOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("edge_share", self.edge_share, Range{0.001, 1},
        "share of pixels whose gradient passes the high threshold, before thinning [0..1]");
}

// gray: H x W. weights: H x W, [0..1], what the gradient is multiplied by; empty = 1. Returns H x
// W, 255 = edge, one pixel wide.
[[nodiscard]] cv::Mat_<std::uint8_t> canny_edges(const cv::Mat_<std::uint8_t>& gray,
                                                 const CannyOptions& options,
                                                 const cv::Mat_<float>& weights = {});

}  // namespace edvo
