// SPDX-License-Identifier: MIT
// From broad bands of edge strength to lines one pixel wide.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace edvo {

// strength: H x W, [0..1]. Returns H x W, 255 where the strength reaches the threshold and is
// greatest across the edge (non-maximum suppression along the normal of the ridge).
[[nodiscard]] cv::Mat_<std::uint8_t> thin_edges(const cv::Mat_<float>& strength, double threshold);

}  // namespace edvo
