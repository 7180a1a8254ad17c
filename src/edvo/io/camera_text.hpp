// SPDX-License-Identifier: MIT
// Parsing of camera files, shared by all formats.
#pragma once

#include "edvo/core/camera.hpp"

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

// A calibration as a file states it, not yet checked.
struct StatedCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // [px]
  std::vector<double> distortion;         // in the lens model's order, or nothing
  cv::Size size;                          // [px], empty if not stated
  LensModel lens = LensModel::kPolynomial;
  std::optional<double> depth_scale = {};  // [units/m], not yet checked
  std::string depth_scale_key = {};        // what the file calls it
};

// Throws Error(kCalibration) "FILE: reason".
[[noreturn]] void fail_camera(const std::filesystem::path& file, std::string_view reason);

// The lens model of any name in use: plumb_bob, radtan, rational_polynomial; equidistant, fisheye.
// None for another model. An empty name means the polynomial.
[[nodiscard]] std::optional<LensModel> lens_model(std::string_view name);

// The names above, for messages.
[[nodiscard]] std::string_view lens_model_names();

// From the matrix fx 0 cx, 0 fy cy, 0 0 1. Throws Error(kCalibration) if it is not of that form.
void set_matrix(StatedCamera& camera, const std::filesystem::path& file,
                std::span<const double> row_by_row);

// Throws Error(kCalibration) if the text is no YAML or describes no camera that edvo knows.
[[nodiscard]] StatedCamera parse_camera_yaml(const std::filesystem::path& file,
                                             std::string_view text);

// The same for JSON: fx, fy, cx or ppx, cy or ppy, or Open3D's intrinsic_matrix; coeffs or
// distortion, or k1 to p2, and the model; also inside "camera".
[[nodiscard]] StatedCamera parse_camera_json(const std::filesystem::path& file,
                                             std::string_view text);

}  // namespace edvo
