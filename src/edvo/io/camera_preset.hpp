// SPDX-License-Identifier: MIT
// Cameras of public data sets, known by the names of their folders and archives.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/io/dataset.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace edvo {

struct CameraPreset {
  std::string name;        // "TUM freiburg1"
  std::string recognised;  // by what: "'fr1' in the name fr1_xyz"
  DistortedCamera camera;
  double depth_scale = 5000;  // [units/m]
};

// By the name of a folder or archive, such as rgbd_dataset_freiburg1_xyz, fr2_desk,
// living_room_traj0_frei_png.
[[nodiscard]] std::optional<CameraPreset> camera_preset(std::string_view name);

// By the dataset's name, its folder's name, or the ground truth file that ICL-NUIM ships.
[[nodiscard]] std::optional<CameraPreset> camera_preset(const Dataset& dataset);

}  // namespace edvo
