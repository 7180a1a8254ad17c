// SPDX-License-Identifier: MIT
// The PNG files that cameras write, decoded faster than a reader of every PNG can.
#pragma once

#include <opencv2/core.hpp>
#include <string_view>

namespace edvo {

// Both return an empty image if the file is damaged or anything but plain: 8-bit gray, RGB or RGBA
// (colour), 16-bit gray (depth), not interlaced, without a chunk beside header, pixels and end. A
// general reader then decodes it or says what is wrong. Pixels are the same as such a reader's.
[[nodiscard]] cv::Mat_<cv::Vec3b> decode_plain_colour(std::string_view png);     // BGR
[[nodiscard]] cv::Mat_<std::uint16_t> decode_plain_depth(std::string_view png);  // file's units

}  // namespace edvo
