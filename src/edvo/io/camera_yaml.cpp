// SPDX-License-Identifier: MIT
// Calibrations as OpenCV, ROS and Kalibr write them.
#include "edvo/core/error.hpp"
#include "edvo/io/camera_text.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>
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

cv::Size size_of(const YAML::Node& width, const YAML::Node& height) {
  return width && height ? cv::Size(width.as<int>(), height.as<int>()) : cv::Size();
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

StatedCamera kalibr_camera(const path& file, const YAML::Node& cam) {
  check_model(file, "camera model", text_of(cam["camera_model"]), {"pinhole"});
  const std::string distortion_model = text_of(cam["distortion_model"]);
  check_model(file, "distortion model", distortion_model, {"radtan", "none"});
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
  if (cam["distortion_coeffs"] && distortion_model != "none")
    camera.distortion = numbers_in(file, cam["distortion_coeffs"]);
  if (cam["resolution"]) {
    const std::vector<double> sides = numbers_in(file, cam["resolution"]);
    if (sides.size() != 2)
      fail_camera(file, fmt::format("cam0: expected resolution [width, height], got {} numbers",
                                    sides.size()));
    camera.size = {cv::saturate_cast<int>(sides[0]), cv::saturate_cast<int>(sides[1])};
  }
  return camera;
}

// OpenCV's and ROS's way: a matrix and a vector.
StatedCamera matrix_camera(const path& file, const YAML::Node& root, const YAML::Node& matrix) {
  check_model(file, "distortion model",
              text_of(find(root, {"distortion_model", "distortion_type"})),
              {"plumb_bob", "radtan", "rational_polynomial"});  // rational: if k4 and on are zero
  check_model(file, "camera model", text_of(root["camera_model"]), {"pinhole"});
  StatedCamera camera;
  set_matrix(camera, file, numbers_in(file, matrix));
  if (const YAML::Node distortion = find(
          root, {"distortion_coefficients", "Distortion_Coefficients", "distortion_coefficents",
                 "dist_coeffs", "distCoeffs", "dist_coeff", "D", "d"}))
    camera.distortion = numbers_in(file, distortion);
  camera.size = size_of(find(root, {"image_width", "image_Width", "width"}),
                        find(root, {"image_height", "image_Height", "height"}));
  return camera;
}

// ORB-SLAM's way, also written through OpenCV: Camera.fx, or just fx.
StatedCamera named_camera(const path& file, const YAML::Node& root, const std::string& prefix) {
  check_model(file, "camera type", text_of(root[prefix + "type"]),
              {"PinHole", "Pinhole", "pinhole"});
  const auto number = [&](const char* key) {
    const YAML::Node node = root[prefix + key];
    if (!node) fail_camera(file, fmt::format("{}{} is missing", prefix, key));
    return node.as<double>();
  };
  const auto number_or_zero = [&](const char* key) {
    const YAML::Node node = root[prefix + key];
    return node ? node.as<double>() : 0.0;
  };
  return {.fx = number("fx"),
          .fy = number("fy"),
          .cx = number("cx"),
          .cy = number("cy"),
          .distortion = {number_or_zero("k1"), number_or_zero("k2"), number_or_zero("p1"),
                         number_or_zero("p2"), number_or_zero("k3")},
          .size = size_of(root[prefix + "width"], root[prefix + "height"])};
}

}  // namespace

StatedCamera parse_camera_yaml(const path& file, std::string_view text) {
  try {
    const YAML::Node root = YAML::Load(without_directives(text));
    if (root.IsMap()) {
      if (const YAML::Node cam = root["cam0"]; cam && cam.IsMap() && cam["intrinsics"])
        return kalibr_camera(file, cam);
      if (const YAML::Node matrix =
              find(root, {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"}))
        return matrix_camera(file, root, matrix);
      for (const char* const prefix : {"Camera.", ""})
        if (root[std::string(prefix) + "fx"]) return named_camera(file, root, prefix);
    }
  } catch (const YAML::Exception& error) {
    throw Error(ErrorCode::kCalibration,
                fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg));
  }
  fail_camera(
      file,
      "no camera found in it; expected fx, fy, cx, cy as TOML, camera_matrix (OpenCV, ROS), "
      "K (ROS), cam0 (Kalibr), Camera.fx, or the numbers fx fy cx cy [k1 k2 p1 p2 [k3]]");
}

}  // namespace edvo
