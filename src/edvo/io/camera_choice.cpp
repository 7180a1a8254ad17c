// SPDX-License-Identifier: MIT
#include "edvo/io/camera_choice.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/camera_preset.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <array>

namespace edvo {
namespace {

constexpr std::array kCameraFiles = {
    "camera.toml", "camera.yaml", "camera.yml", "calibration.yaml", "calibration.yml",
    "calibration.txt", "camera_info.yaml", "intrinsics.txt",
    // ScanNet; Open3D's and Redwood's recorders; Replica
    "intrinsic/intrinsic_depth.txt", "camera_intrinsic.json", "intrinsic.json",
    "camera_primesense.json", "../cam_params.json", "../../cam_params.json"};

[[noreturn]] void fail_without_camera(const Dataset& dataset, const std::string& reason) {
  throw Error(
      ErrorCode::kCalibration,
      fmt::format("{}: {}; give one with --camera FILE (TOML, OpenCV, ROS or Kalibr YAML, or one "
                  "line fx fy cx cy [k1 k2 p1 p2 k3]), put it into the folder as {}, or name the "
                  "folder after its data set (fr1, fr2, fr3, icl)",
                  dataset.source.string(), reason, kCameraFiles.front()));
}

}  // namespace

ChosenCamera choose_camera(const Dataset& dataset,
                           const std::optional<std::filesystem::path>& calibration) {
  if (calibration)
    return {.camera = read_camera(*calibration, dataset.image_size),
            .source = fmt::format("{}, as given", calibration->string())};
  for (const char* const name : kCameraFiles) {
    const std::filesystem::path file = dataset.root / name;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored))
      return {.camera = read_camera(file, dataset.image_size),
              .source = fmt::format("{}, which is in the folder", file.string())};
  }
  const std::optional<CameraPreset> preset = camera_preset(dataset);
  if (!preset)
    fail_without_camera(dataset, fmt::format("the camera is not known: no {} in the folder, and "
                                             "the name {} tells none",
                                             fmt::join(kCameraFiles, ", "), dataset.name));
  const Camera& pinhole = preset->camera.pinhole;
  if (cv::Size(pinhole.width, pinhole.height) != dataset.image_size)
    fail_without_camera(
        dataset, fmt::format("camera {} ({}) has images of {} x {} px, these have {} x {} px",
                             preset->name, preset->recognised, pinhole.width, pinhole.height,
                             dataset.image_size.width, dataset.image_size.height));
  return {.camera = preset->camera,
          .source = fmt::format("{}, {}", preset->name, preset->recognised)};
}

}  // namespace edvo
