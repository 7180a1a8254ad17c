// SPDX-License-Identifier: MIT
// Calibrations as Open3D's recorders, NICE-SLAM's renders and librealsense's intrinsics have them.
#include "edvo/core/error.hpp"
#include "edvo/io/camera_text.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
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

// librealsense's and OpenCV's names; "RS2_DISTORTION_BROWN_CONRADY", "Brown Conrady".
std::optional<LensModel> lens_in(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) {
    return c == ' ' || c == '.' || c == '-' ? '_' : static_cast<char>(std::tolower(c));
  });
  for (const std::string_view prefix : {"rs2_", "distortion_"})
    if (name.starts_with(prefix)) name.erase(0, prefix.size());
  for (const char* const polynomial : {"brown_conrady", "none", "pinhole"})
    if (name == polynomial) return LensModel::kPolynomial;
  if (name == "kannala_brandt4") return LensModel::kEquidistant;
  return lens_model(name);
}

std::vector<double> coefficients_in(const path& file, const json& object) {
  std::vector<double> coefficients;
  for (const char* const key : {"coeffs", "distortion", "distortion_coefficients"})
    if (const auto values = object.find(key); values != object.end()) {
      if (!values->is_array())
        fail_camera(file, fmt::format("{} must be an array of numbers", key));
      for (const json& value : *values) {
        if (!value.is_number())
          fail_camera(file, fmt::format("{} must be an array of numbers", key));
        coefficients.push_back(value.get<double>());
      }
      return coefficients;
    }
  for (const char* const key : {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"})
    coefficients.push_back(object.contains(key) ? number(file, object, {key}) : 0);
  return coefficients;
}

// A model that is not known does not matter where all is zero.
void set_lens(StatedCamera& camera, const path& file, const json& object) {
  camera.distortion = coefficients_in(file, object);
  const bool is_zero = std::ranges::all_of(camera.distortion, [](double k) { return k == 0; });
  for (const char* const key : {"model", "distortion_model"}) {
    const auto model = object.find(key);
    if (model == object.end()) continue;
    const auto lens = model->is_string() ? lens_in(model->get<std::string>()) : std::nullopt;
    if (!lens && !is_zero)
      fail_camera(file, fmt::format("{} {}: this model of distortion is not read, only "
                                    "brown_conrady, kannala_brandt4, {}",
                                    key, printable(model->dump()), lens_model_names()));
    camera.lens = lens.value_or(LensModel::kPolynomial);
  }
  if (is_zero) camera.distortion.clear();
}

}  // namespace

StatedCamera parse_camera_json(const path& file, std::string_view text) {
  const json whole = json::parse(text, nullptr, false);
  if (!whole.is_object()) fail_camera(file, "is no JSON object");
  const json& object = whole.contains("camera") ? whole["camera"] : whole;
  if (!object.is_object()) fail_camera(file, "camera must be an object");
  StatedCamera camera;
  camera.size = size_in(file, object);
  set_lens(camera, file, object);
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
