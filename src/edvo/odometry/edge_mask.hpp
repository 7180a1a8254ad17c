// SPDX-License-Identifier: MIT
// Edges of a keyframe, by the detector that the options name.
#pragma once

#include "edvo/features/edge_detector.hpp"
#include "edvo/image/frame.hpp"
#include "edvo/odometry/config.hpp"

namespace edvo {

// Candidates for tracking before corner optimization: H x W, 255 = edge; everything without
// detector.
// network: not null where the options ask for one.
[[nodiscard]] cv::Mat_<std::uint8_t> edge_mask(const Frame& frame, const Undistortion& undistortion,
                                               const EdgeDetector* network, const Config& config);

}  // namespace edvo
