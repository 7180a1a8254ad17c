// SPDX-License-Identifier: MIT
// Calibrations as Open3D's recorders and NICE-SLAM's renders have them.
#include "edvo/core/error.hpp"
#include "edvo/io/camera_text.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

namespace edvo {
namespace {

using nlohmann::json;
using std::filesystem::path;

// The number of the first of these keys that is there.
double number(const path& file, const json& object, std::initializer_list<const char*> keys) {
  for (const char* const key : keys)
    if (const auto value = object.find(key); value != object.end()) {
      if (!value->is_number()) fail_camera(file, fmt::format("{} must be a number", key));
      return value->get<double>();
    }
  fail_camera(file, fmt::format("{} is missing", *keys.begin()));
}

cv::Size size_in(const path& file, const json& object) {
  if (!object.contains("width") && !object.contains("w")) return {};
  const double width = number(file, object, {"width", "w"});
  const double height = number(file, object, {"height", "h"});
  constexpr double kLargestSide = 1e6;
  if (!(width > 0 && height > 0 && width <= kLargestSide && height <= kLargestSide))
    fail_camera(file, fmt::format("{} x {} is no size in pixels", width, height));
  return {static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace

StatedCamera parse_camera_json(const path& file, std::string_view text) {
  const json whole = json::parse(text, nullptr, false);
  if (!whole.is_object()) fail_camera(file, "is no JSON object");
  const json& object = whole.contains("camera") ? whole["camera"] : whole;
  if (!object.is_object()) fail_camera(file, "camera must be an object");
  StatedCamera camera;
  camera.size = size_in(file, object);
  if (const auto matrix = object.find("intrinsic_matrix"); matrix != object.end()) {
    if (!matrix->is_array() || matrix->size() != 9)
      fail_camera(file, "intrinsic_matrix must have 9 numbers");
    std::array<double, 9> m{};  // column by column in the file
    for (std::size_t i = 0; i < m.size(); ++i) {
      if (!(*matrix)[i].is_number()) fail_camera(file, "intrinsic_matrix must have 9 numbers");
      m[i % 3 * 3 + i / 3] = (*matrix)[i].get<double>();
    }
    set_matrix(camera, file, m);
    return camera;
  }
  camera.fx = number(file, object, {"fx"});
  camera.fy = number(file, object, {"fy"});
  camera.cx = number(file, object, {"cx", "ppx"});
  camera.cy = number(file, object, {"cy", "ppy"});
  if (object.contains("scale")) {  // NICE-SLAM's
    camera.depth_scale = number(file, object, {"scale"});
    camera.depth_scale_key = "scale";
  }
  return camera;
}

}  // namespace edvo
