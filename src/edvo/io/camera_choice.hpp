// SPDX-License-Identifier: MIT
// Which camera took a data set.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/io/dataset.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace edvo {

struct ChosenCamera {
  DistortedCamera camera;
  std::string source;  // what was picked and why: "TUM freiburg1, 'fr1' in the name fr1_xyz"
};

// The calibration file if one is given; else one in the dataset's folder (camera.toml,
// camera.yaml, calibration.txt, camera_info.yaml, intrinsics.txt, ...); else the preset that the
// names tell. Throws Error(kCalibration) that says what can be done if there is none.
[[nodiscard]] ChosenCamera choose_camera(
    const Dataset& dataset, const std::optional<std::filesystem::path>& calibration = {});

}  // namespace edvo
