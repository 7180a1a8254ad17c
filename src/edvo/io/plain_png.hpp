// SPDX-License-Identifier: MIT
// Decodes the plain PNG files that cameras write faster than a general PNG reader.
#pragma once

#include <opencv2/core.hpp>
#include <string_view>

namespace edvo {

// Both return an empty image if the file is damaged or anything but plain: 8-bit gray, RGB or RGBA
// (colour), 16-bit gray (depth), not interlaced, without chunks besides header, pixels and end. A
// general reader must then decode the file or report the error. Pixels equal those of a general
// reader.
[[nodiscard]] cv::Mat_<cv::Vec3b> decode_plain_colour(std::string_view png);     // BGR
[[nodiscard]] cv::Mat_<std::uint16_t> decode_plain_depth(std::string_view png);  // file's units

}  // namespace edvo
