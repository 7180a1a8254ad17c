// SPDX-License-Identifier: MIT
// Whether the depth measured at an edge pixel is that of the surface whose edge it is.
#pragma once

#include <opencv2/core.hpp>

namespace edvo {

// Pixels around that the test below reads, to each side.
constexpr int kEdgeDepthRadius = 3;

// True where the pixel's own depth belongs to the nearest surface around it. A surface is a depth
// that a quarter of the 7 x 7 pixels have, within 4 %. False for a pixel without depth, one whose
// depth stands alone (stray, flying pixel, speckle), and one of the background beside a foreground:
// there the image edge is the foreground's. Where all depths around are alike, missing ones are no
// objection.
// depth: H x W [m], NaN = none. pixel: at least 4 px from the border.
[[nodiscard]] bool on_nearest_surface(const cv::Mat_<float>& depth, cv::Point pixel);

}  // namespace edvo
