// SPDX-License-Identifier: MIT
// Calibrations as OpenCV, ROS and Kalibr write them.
#include "edvo/core/error.hpp"
#include "edvo/io/camera_text.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>
#include <cmath>
#include <initializer_list>
#include <sstream>
#include <string>

namespace edvo {
namespace {

using std::filesystem::path;

// OpenCV starts with "%YAML:1.0", which is not YAML; an empty line keeps the line numbers.
std::string without_directives(std::string_view text) {
  std::istringstream lines{std::string(text)};
  std::string all;
  for (std::string line; std::getline(lines, line);)
    all += (line.starts_with('%') ? "" : line) + '\n';
  return all;
}

// The value of the first of these keys that is there; null if none is.
YAML::Node find(const YAML::Node& map, std::initializer_list<const char*> keys) {
  for (const char* const key : keys)
    if (const YAML::Node node = map[key]) return node;
  return YAML::Node(YAML::NodeType::Undefined);
}

std::vector<double> numbers_in(const path& file, const YAML::Node& node) {
  const YAML::Node values = node.IsMap() ? node["data"] : node;  // a matrix has rows, cols and data
  if (!values || !values.IsSequence())
    fail_camera(file, fmt::format("line {}: expected a list of numbers", node.Mark().line + 1));
  return values.as<std::vector<double>>();
}

std::string text_of(const YAML::Node& node) {
  return node && node.IsScalar() ? node.Scalar() : std::string();
}

int side_of(const path& file, double value) {
  constexpr double kLargestSide = 1e6;  // [px]
  if (!(value >= 1 && value <= kLargestSide) || value != std::floor(value))
    fail_camera(file, fmt::format("{} is no size in pixels", value));
  return static_cast<int>(value);
}

cv::Size size_of(const path& file, const YAML::Node& width, const YAML::Node& height) {
  if (!width || !height) return {};
  return {side_of(file, width.as<double>()), side_of(file, height.as<double>())};
}

void check_model(const path& file, const std::string& what, const std::string& model,
                 std::initializer_list<std::string_view> supported) {
  if (model.empty()) return;
  std::string names;
  for (const std::string_view name : supported) {
    if (model == name) return;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  }
  fail_camera(file, fmt::format("{} {} is not supported, only {}", what, printable(model), names));
}

LensModel lens_of(const path& file, const std::string& model) {
  if (const auto lens = lens_model(model)) return *lens;
  fail_camera(file, fmt::format("distortion model {} is not supported, only {}", printable(model),
                                lens_model_names()));
}

StatedCamera kalibr_camera(const path& file, const YAML::Node& cam) {
  check_model(file, "camera model", text_of(cam["camera_model"]), {"pinhole"});
  const std::string distortion_model = text_of(cam["distortion_model"]);
  const std::vector<double> intrinsics = numbers_in(file, cam["intrinsics"]);
  if (intrinsics.size() != 4)
    fail_camera(file,
                fmt::format("cam0: expected intrinsics of 4 numbers, got {}", intrinsics.size()));
  StatedCamera camera{.fx = intrinsics[0],
                      .fy = intrinsics[1],
                      .cx = intrinsics[2],
                      .cy = intrinsics[3],
                      .distortion = {},
                      .size = {}};
  if (distortion_model != "none") {
    camera.lens = lens_of(file, distortion_model);
    if (cam["distortion_coeffs"]) camera.distortion = numbers_in(file, cam["distortion_coeffs"]);
  }
  if (cam["resolution"]) {
    const std::vector<double> sides = numbers_in(file, cam["resolution"]);
    if (sides.size() != 2)
      fail_camera(file, fmt::format("cam0: expected resolution [width, height], got {} numbers",
                                    sides.size()));
    camera.size = {side_of(file, sides[0]), side_of(file, sides[1])};
  }
  return camera;
}

// OpenCV's and ROS's way: a matrix and a vector.
StatedCamera matrix_camera(const path& file, const YAML::Node& root, const YAML::Node& matrix) {
  check_model(file, "camera model", text_of(root["camera_model"]), {"pinhole"});
  StatedCamera camera;
  camera.lens = lens_of(file, text_of(find(root, {"distortion_model", "distortion_type"})));
  if (text_of(root["fisheye_model"]) == "1") camera.lens = LensModel::kEquidistant;
  set_matrix(camera, file, numbers_in(file, matrix));
  if (const YAML::Node distortion = find(
          root, {"distortion_coefficients", "Distortion_Coefficients", "distortion_coefficents",
                 "dist_coeffs", "distCoeffs", "dist_coeff", "D", "d"}))
    camera.distortion = numbers_in(file, distortion);
  camera.size = size_of(file, find(root, {"image_width", "image_Width", "width"}),
                        find(root, {"image_height", "image_Height", "height"}));
  return camera;
}

// ORB-SLAM's way, also written through OpenCV: Camera.fx or Camera1.fx, or just fx. Type and size
// are those of "Camera." in any case.
StatedCamera named_camera(const path& file, const YAML::Node& root, const std::string& prefix) {
  const std::string common = prefix.empty() ? "" : "Camera.";
  const std::string type = text_of(root[common + "type"]);
  check_model(file, "camera type", type, {"PinHole", "Pinhole", "pinhole", "KannalaBrandt8"});
  const auto number = [&](const char* key) {
    const YAML::Node node = root[prefix + key];
    if (!node) fail_camera(file, fmt::format("{}{} is missing", prefix, key));
    return node.as<double>();
  };
  StatedCamera camera{.fx = number("fx"),
                      .fy = number("fy"),
                      .cx = number("cx"),
                      .cy = number("cy"),
                      .distortion = {},
                      .size = size_of(file, root[common + "width"], root[common + "height"])};
  const auto add = [&](std::initializer_list<const char*> keys) {
    for (const char* const key : keys) {
      const YAML::Node node = root[prefix + key];
      camera.distortion.push_back(node ? node.as<double>() : 0.0);
    }
  };
  if (type == "KannalaBrandt8") {
    camera.lens = LensModel::kEquidistant;
    add({"k1", "k2", "k3", "k4"});
  } else {
    add({"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"});
  }
  return camera;
}

std::optional<StatedCamera> camera_in(const path& file, const YAML::Node& root) {
  if (const YAML::Node cam = root["cam0"]; cam && cam.IsMap() && cam["intrinsics"])
    return kalibr_camera(file, cam);
  if (const YAML::Node matrix =
          find(root, {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"}))
    return matrix_camera(file, root, matrix);
  for (const char* const prefix : {"Camera.", "Camera1.", ""})
    if (root[std::string(prefix) + "fx"]) return named_camera(file, root, prefix);
  return std::nullopt;
}

void add_depth_scale(StatedCamera& camera, const YAML::Node& root) {
  for (const char* const key : {"depth_scale", "DepthMapFactor", "RGBD.DepthMapFactor"})
    if (const YAML::Node node = root[key]) {
      camera.depth_scale = node.as<double>();
      camera.depth_scale_key = key;
      return;
    }
}

}  // namespace

StatedCamera parse_camera_yaml(const path& file, std::string_view text) {
  try {
    const YAML::Node root = YAML::Load(without_directives(text));
    if (auto camera = root.IsMap() ? camera_in(file, root) : std::nullopt) {
      add_depth_scale(*camera, root);
      return *camera;
    }
  } catch (const YAML::Exception& error) {
    throw Error(ErrorCode::kCalibration,
                fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg));
  }
  fail_camera(
      file,
      "no camera found in it; expected fx, fy, cx, cy as TOML, camera_matrix (OpenCV, ROS), "
      "K (ROS), cam0 (Kalibr), Camera.fx, or the numbers fx fy cx cy [k1 k2 p1 p2 [k3 [k4 k5 "
      "k6]]]");
}

}  // namespace edvo
