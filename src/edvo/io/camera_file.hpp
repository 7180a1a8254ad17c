// SPDX-License-Identifier: MIT
// Calibrations of one camera from and to files.
#pragma once

#include "edvo/core/camera.hpp"

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>

namespace edvo {

// Reads any of these, recognised by content, whatever the file is called:
// - our TOML: fx, fy, cx, cy; optional width, height, distortion = [k1 ... k3]
// - OpenCV YAML: camera_matrix, distortion_coefficients; or Camera.fx, Camera.k1
// - ROS camera_info YAML: camera_matrix or K; plumb_bob
// - Kalibr camchain YAML: cam0 is taken; pinhole with radtan or no distortion
// - JSON: fx, fy, cx, cy (NICE-SLAM's cam_params.json), or Open3D's intrinsic_matrix
// - numbers: fx fy cx cy [k1 k2 p1 p2 [k3]], or the 3 x 3 or 4 x 4 matrix row by row
// image_size is that of the images; an empty one is taken from the file. Throws
// Error(kCalibration) if the file is none of these, has another camera model, is for images of
// another size or cannot be right.
[[nodiscard]] DistortedCamera read_camera(const std::filesystem::path& file, cv::Size image_size);

// Our TOML; read_camera() gives the same camera back, to the last bit.
[[nodiscard]] std::string camera_to_toml(const DistortedCamera& camera);

}  // namespace edvo
