// SPDX-License-Identifier: MIT
// Reads and writes images: colour as PNG or JPEG, depth as 16-bit PNG.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>

namespace edvo {

// Images whose header states more are refused before memory is allocated.
inline constexpr int kLargestImageSide = 16384;         // [px]
inline constexpr std::int64_t kMostPixels = 1LL << 26;  // [px]

// Any PNG or JPEG as 8-bit BGR, H x W: gray is copied to all channels, 16 bit is reduced to 8,
// transparency and EXIF orientation are ignored (a calibration belongs to the sensor's pixels). The
// format is recognised by content. Throws Error(kInput) naming the file if it is missing, damaged,
// truncated or neither.
[[nodiscard]] cv::Mat_<cv::Vec3b> read_colour(const std::filesystem::path& path);

// A 16-bit single-channel PNG, H x W, in the file's units. Throws Error(kInput) for anything else.
[[nodiscard]] cv::Mat_<std::uint16_t> read_depth_raw(const std::filesystem::path& path);

// raw / units_per_metre [m]; 0 (no return) and 65535 (saturated) become NaN.
[[nodiscard]] cv::Mat_<float> depth_to_metres(const cv::Mat_<std::uint16_t>& raw,
                                              double units_per_metre);

// Writes CV_8UC3 (BGR), CV_8UC1 or CV_16UC1, optimized for speed, not size. Throws Error(kOutput)
// and leaves no file behind if it cannot be written.
void write_png(const std::filesystem::path& path, const cv::Mat& image);

}  // namespace edvo
