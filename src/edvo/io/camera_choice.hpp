// SPDX-License-Identifier: MIT
// Chooses the camera of a data set.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/io/dataset.hpp"

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

struct ChosenCamera {
  DistortedCamera camera;
  std::string source;  // what was picked and why: "TUM freiburg1, 'fr1' in the name fr1_xyz"
  std::vector<std::string> warnings = {};  // what looks wrong about it
};

struct CameraOptions {
  std::optional<std::filesystem::path> file = {};  // empty = by the folder or its name
  cv::Size size = {};  // [px] of the calibration images, empty = that of the data
};

// The calibration file if one is given; else one in the dataset's folder (camera.toml,
// camera.yaml, calibration.txt, camera_info.yaml, intrinsics.txt, ...); else the preset of
// the data set's name. Scaled to the images if options.size is another size. Throws
// Error(kCalibration), with possible remedies, if there is none.
[[nodiscard]] ChosenCamera choose_camera(const Dataset& dataset, const CameraOptions& options = {});

// The calibration file in a folder, by its name.
[[nodiscard]] std::optional<std::filesystem::path> camera_file_in(
    const std::filesystem::path& folder);

// The same lens and sensor after its image was resized to `size`; width and height may scale
// differently.
[[nodiscard]] DistortedCamera resized(const DistortedCamera& camera, cv::Size size);

// Warnings about intrinsics that suggest images of another size: a principal point more than 10 %
// off the middle, a field of view below 25 or above 130 degrees.
[[nodiscard]] std::vector<std::string> check_intrinsics(const DistortedCamera& camera);

}  // namespace edvo
