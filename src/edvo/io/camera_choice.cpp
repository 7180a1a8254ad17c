// SPDX-License-Identifier: MIT
#include "edvo/io/camera_choice.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/camera_preset.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {
namespace {

constexpr std::array kCameraFiles = {
    "camera.toml", "camera.yaml", "camera.yml", "calibration.yaml", "calibration.yml",
    "calibration.txt", "camera_info.yaml", "intrinsics.txt", "intrinsic.txt", "camera.txt",
    "intrinsic/camera.txt", "intrinsic/intrinsic.txt", "intrinsic/intrinsics.txt",
    // ScanNet; Open3D's and Redwood's recorders; 3DMatch, beside its seq-NN; Replica
    "intrinsic/intrinsic_depth.txt", "camera_intrinsic.json", "intrinsic.json",
    "camera_primesense.json", "camera-intrinsics.txt", "../camera-intrinsics.txt",
    "../cam_params.json", "../../cam_params.json"};

[[noreturn]] void fail_without_camera(const Dataset& dataset, const std::string& reason) {
  throw Error(
      ErrorCode::kCalibration,
      fmt::format("{}: {}; give one with --camera FILE (TOML, OpenCV, ROS or Kalibr YAML, or one "
                  "line fx fy cx cy [k1 k2 p1 p2 [k3]]), put it into the folder as {}, or name the "
                  "folder after its data set (fr1, fr2, fr3, icl)",
                  dataset.source.string(), reason, kCameraFiles.front()));
}

std::string size_text(cv::Size size) {
  return fmt::format("{} x {} px", size.width, size.height);
}

ChosenCamera preset_for(const Dataset& dataset, cv::Size calibrated) {
  const std::optional<CameraPreset> preset = camera_preset(dataset);
  if (!preset)
    fail_without_camera(dataset, fmt::format("the camera is not known: no {} in the folder, and "
                                             "the name {} tells none",
                                             fmt::join(kCameraFiles, ", "), dataset.name));
  const Camera& pinhole = preset->camera.pinhole;
  if (cv::Size(pinhole.width, pinhole.height) != calibrated)
    fail_without_camera(
        dataset,
        fmt::format("camera {} ({}) has images of {} x {} px, these have {} (if they were resized: "
                    "--camera-size {}x{})",
                    preset->name, preset->recognised, pinhole.width, pinhole.height,
                    size_text(calibrated), pinhole.width, pinhole.height));
  return {.camera = preset->camera,
          .source = fmt::format("{}, {}", preset->name, preset->recognised)};
}

ChosenCamera as_calibrated(const Dataset& dataset, const CameraOptions& options,
                           cv::Size calibrated) {
  const auto file = options.file ? options.file : camera_file_in(dataset.root);
  if (!file) return preset_for(dataset, calibrated);
  ChosenCamera chosen{.camera = read_camera(*file, calibrated),
                      .source = fmt::format("{}, {}", file->string(),
                                            options.file ? "as given" : "which is in the folder")};
  if (const auto warning = camera_file_warning(*file)) chosen.warnings.push_back(*warning);
  return chosen;
}

constexpr double kDegreesPerRadian = 57.29577951308232;

// Horizontally. [deg]
double field_of_view(const DistortedCamera& camera) {
  const double half = 0.5 * camera.pinhole.width / camera.pinhole.fx;
  return 2 * kDegreesPerRadian * (camera.lens == LensModel::kEquidistant ? half : std::atan(half));
}

// How far the lens moves a corner of the image, at most. [px]
double largest_displacement(const DistortedCamera& camera) {
  const Camera& c = camera.pinhole;
  double largest = 0;
  for (const double u : {0.0, c.width - 1.0})
    for (const double v : {0.0, c.height - 1.0}) {
      const Eigen::Vector2d ray((u - c.cx) / c.fx, (v - c.cy) / c.fy);
      const Eigen::Vector2d moved = distort(camera, ray) - ray;
      largest = std::max(largest, std::hypot(c.fx * moved.x(), c.fy * moved.y()));
    }
  return largest;
}

}  // namespace

std::optional<std::filesystem::path> camera_file_in(const std::filesystem::path& folder) {
  for (const char* const name : kCameraFiles) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

DistortedCamera resized(const DistortedCamera& camera, cv::Size size) {
  const Camera& from = camera.pinhole;
  const double x = static_cast<double>(size.width) / from.width;
  const double y = static_cast<double>(size.height) / from.height;
  DistortedCamera to = camera;
  // The borders of the image stay where they are; pixel centres are integers.
  to.pinhole = {.fx = from.fx * x,
                .fy = from.fy * y,
                .cx = (from.cx + 0.5) * x - 0.5,
                .cy = (from.cy + 0.5) * y - 0.5,
                .width = size.width,
                .height = size.height};
  return to;
}

std::vector<std::string> check_intrinsics(const DistortedCamera& camera) {
  constexpr double kFarthestOff = 0.1;              // of the side
  constexpr double kFarthestMoved = 0.5;            // of the width
  constexpr double kNarrowest = 25, kWidest = 130;  // [deg]
  const Camera& pinhole = camera.pinhole;
  std::vector<std::string> warnings;
  const double off_x = (pinhole.cx + 0.5) / pinhole.width - 0.5;
  const double off_y = (pinhole.cy + 0.5) / pinhole.height - 0.5;
  if (std::max(std::abs(off_x), std::abs(off_y)) > kFarthestOff)
    warnings.push_back(fmt::format(
        "principal point {:.6g}, {:.6g} lies {:.0f} % of the width and {:.0f} % of the height off "
        "the middle of {} x {} px; are the intrinsics those of images of about {:.0f} x {:.0f} px? "
        "If they were only resized, --camera-size WIDTHxHEIGHT of the calibration scales them",
        pinhole.cx, pinhole.cy, 100 * std::abs(off_x), 100 * std::abs(off_y), pinhole.width,
        pinhole.height, 2 * pinhole.cx + 1, 2 * pinhole.cy + 1));
  const double degrees = field_of_view(camera);
  if (degrees < kNarrowest || (degrees > kWidest && camera.lens != LensModel::kEquidistant))
    warnings.push_back(
        fmt::format("fx = {:.6g} gives a field of view of {:.0f} degrees across {} px, outside {} "
                    "to {}; are the intrinsics those of images of another size? --camera-size "
                    "WIDTHxHEIGHT scales them",
                    pinhole.fx, degrees, pinhole.width, kNarrowest, kWidest));
  if (camera.lens != LensModel::kEquidistant &&
      !(largest_displacement(camera) < kFarthestMoved * pinhole.width))
    warnings.push_back(fmt::format(
        "the distortion [{:.6g}] moves a corner of the image by {:.0f} px, which no lens does; is "
        "the order k1 k2 p1 p2 k3?",
        fmt::join(distortion_coefficients(camera), ", "), largest_displacement(camera)));
  return warnings;
}

ChosenCamera choose_camera(const Dataset& dataset, const CameraOptions& options) {
  constexpr double kSameShape = 0.01;  // of the ratio of the sides, for rounding
  const bool is_resized = !options.size.empty() && options.size != dataset.image_size;
  ChosenCamera chosen =
      as_calibrated(dataset, options, is_resized ? options.size : dataset.image_size);
  if (is_resized) {
    chosen.camera = resized(chosen.camera, dataset.image_size);
    chosen.source += fmt::format(", scaled from {} to {}", size_text(options.size),
                                 size_text(dataset.image_size));
  }
  const std::vector<std::string> doubts = check_intrinsics(chosen.camera);
  chosen.warnings.insert(chosen.warnings.end(), doubts.begin(), doubts.end());
  if (is_resized &&
      std::abs(options.size.aspectRatio() / dataset.image_size.aspectRatio() - 1) > kSameShape)
    chosen.warnings.push_back(
        fmt::format("the camera's images of {} have another shape than these of {}: right only if "
                    "they were stretched, not if they were cropped",
                    size_text(options.size), size_text(dataset.image_size)));
  return chosen;
}

}  // namespace edvo
