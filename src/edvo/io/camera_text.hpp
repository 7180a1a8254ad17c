// SPDX-License-Identifier: MIT
// The parts that camera files of every format are made of.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <span>
#include <string_view>
#include <vector>

namespace edvo {

// A calibration as a file states it, not yet checked.
struct StatedCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // [px]
  std::vector<double> distortion;         // k1 k2 p1 p2 [k3 ...], or nothing
  cv::Size size;                          // [px], empty if not stated
};

// Throws Error(kCalibration) "FILE: reason".
[[noreturn]] void fail_camera(const std::filesystem::path& file, std::string_view reason);

// From the matrix fx 0 cx, 0 fy cy, 0 0 1. Throws Error(kCalibration) if it is not of that form.
void set_matrix(StatedCamera& camera, const std::filesystem::path& file,
                std::span<const double> row_by_row);

// Throws Error(kCalibration) if the text is no YAML or describes no camera that we know.
[[nodiscard]] StatedCamera parse_camera_yaml(const std::filesystem::path& file,
                                             std::string_view text);

// The same for JSON: fx, fy, cx, cy, or Open3D's intrinsic_matrix; also inside "camera".
[[nodiscard]] StatedCamera parse_camera_json(const std::filesystem::path& file,
                                             std::string_view text);

}  // namespace edvo
