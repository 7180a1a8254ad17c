// SPDX-License-Identifier: MIT
// The depth of the surface whose edge an edge pixel is.
#pragma once

#include <opencv2/core.hpp>

namespace edvo {

// Pixels around that the test below reads, to each side.
constexpr int kEdgeDepthRadius = 3;

// The pixel's own depth, if it belongs to the nearest surface around; else the mean depth of those
// of its four neighbours that do; NaN if none does. A surface is a depth that a quarter of the 7 x
// 7 pixels have, within 4 %. So a depth that stands alone (stray, flying pixel, speckle) is not
// taken, and neither is the background's beside a foreground, whose outline the image edge is.
// Where all depths around are alike, missing ones are no objection. NaN for a pixel without depth.
// depth: H x W [m], NaN = none. pixel: at least 4 px from the border.
[[nodiscard]] float edge_depth(const cv::Mat_<float>& depth, cv::Point pixel);

}  // namespace edvo
