// SPDX-License-Identifier: MIT
// Stores edge strength on disk without rounding.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

namespace edvo {

// strength: H x W, [0..1]. The file is complete or absent, and has a checksum. Throws
// Error(kOutput) naming the file.
void write_strength(const std::filesystem::path& path, const cv::Mat_<float>& strength);

// None if there is no such file. Throws Error(kInput) naming it if it is damaged or unreadable.
[[nodiscard]] std::optional<cv::Mat_<float>> find_strength(const std::filesystem::path& path);

// For other programs: NumPy's .npy, H x W, 32-bit floats. Throws Error(kOutput) naming the file.
void write_npy(const std::filesystem::path& path, const cv::Mat_<float>& values);

}  // namespace edvo
