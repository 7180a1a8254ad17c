// SPDX-License-Identifier: MIT
// Reads and writes the calibration of one camera.
#pragma once

#include "edvo/core/camera.hpp"

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace edvo {

// Reads any of these, recognised by content, whatever the file is called:
// - our TOML: fx, fy, cx, cy; optional width, height, distortion = [k1 ... k3], distortion_model,
//   depth_scale
// - OpenCV YAML: camera_matrix, distortion_coefficients, fisheye_model; or ORB-SLAM's Camera.fx,
//   Camera1.fx, Camera.k1, Camera.type
// - ROS camera_info YAML: camera_matrix or K; plumb_bob, rational_polynomial, equidistant
// - Kalibr camchain YAML: cam0 is taken; pinhole with radtan, equidistant or no distortion
// - JSON: fx, fy, cx, cy (NICE-SLAM's cam_params.json; ppx, ppy, coeffs and model of librealsense),
//   or Open3D's intrinsic_matrix
// - numbers: fx fy cx cy [k1 k2 p1 p2 [k3 [k4 k5 k6]]], or fx fy cx cy width height, or the 3 x 3
// or 4 x 4 matrix row by row image_size: that of the images [px]; if empty, the file must state it.
// Throws Error(kCalibration) if the file is none of these, has another camera model, is for images
// of another size or has impossible values.
[[nodiscard]] DistortedCamera read_camera(const std::filesystem::path& file, cv::Size image_size);

// Throws Error(kCalibration) beginning with the file, or whoever says so, if no camera of this kind
// has these values: not finite, numbers in other units or in another order.
void require_possible(const std::filesystem::path& file, const DistortedCamera& camera);

struct StatedDepthScale {
  double units_per_metre = 0;
  std::string key;  // what the file calls it
};

// The depth scale that a camera file states: depth_scale, or ORB-SLAM's DepthMapFactor and
// RGBD.DepthMapFactor. None if it states none, is no camera file or cannot be read (read_camera()
// reports that). Throws Error(kCalibration) if it is not a positive number.
[[nodiscard]] std::optional<StatedDepthScale> stated_depth_scale(const std::filesystem::path& file);

// A warning about a file that can be read but looks wrong: an equidistant lens with more than four
// coefficients. Throws what read_camera() throws.
[[nodiscard]] std::optional<std::string> camera_file_warning(const std::filesystem::path& file);

// Our TOML; read_camera() gives the same camera back, to the last bit.
[[nodiscard]] std::string camera_to_toml(const DistortedCamera& camera);

}  // namespace edvo
