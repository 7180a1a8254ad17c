// SPDX-License-Identifier: MIT
#include "edvo/io/camera_file.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/parse_toml.hpp"
#include "edvo/io/camera_text.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

namespace edvo {
namespace {

using std::filesystem::path;

constexpr std::size_t kLargestCameraFile = std::size_t{1} << 20;  // [bytes]
constexpr std::string_view kFormats =
    "TOML (fx, fy, cx, cy), OpenCV YAML, ROS camera_info YAML, Kalibr camchain YAML, JSON or the "
    "numbers fx fy cx cy [k1 k2 p1 p2 [k3 [k4 k5 k6]]] or fx fy cx cy width height";

std::string read_text(const path& file) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  try {
    const std::string text = read_file(file, kLargestCameraFile);
    return text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text;
  } catch (const Error& error) {
    throw Error(ErrorCode::kCalibration, error.what());
  }
}

// The text without blank lines, comments and YAML's directives, to see what it starts with.
std::string significant(std::string_view text) {
  std::istringstream lines{std::string(text)};
  std::string all;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#' || line[first] == '%' ||
        line.starts_with("---"))
      continue;
    all += line.substr(first) + '\n';
  }
  return all;
}

// All of the text as numbers apart by blanks or commas; empty if there is anything else.
std::optional<std::vector<double>> as_numbers(std::string text) {
  std::ranges::replace(text, ',', ' ');
  std::istringstream words(text);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const char* const begin = word.data() + (word.front() == '+' ? 1 : 0);
    const char* const end = word.data() + word.size();
    const auto [stop, status] = std::from_chars(begin, end, numbers.emplace_back());
    if (stop != end || status != std::errc{}) return std::nullopt;
  }
  return numbers;
}

void set_pinhole(StatedCamera& camera, const std::vector<double>& numbers) {
  camera.fx = numbers[0];
  camera.fy = numbers[1];
  camera.cx = numbers[2];
  camera.cy = numbers[3];
}

StatedCamera camera_of_numbers(const path& file, const std::vector<double>& numbers) {
  StatedCamera camera;
  const std::size_t count = numbers.size();
  if (count == 16) {  // ScanNet: the matrix with a row and a column of the unit matrix
    const auto n = [&](int i) { return numbers[static_cast<std::size_t>(i)]; };
    set_matrix(camera, file, std::array{n(0), n(1), n(2), n(4), n(5), n(6), n(8), n(9), n(10)});
  } else if (count == 9 && numbers[1] == 0 && numbers[3] == 0) {
    set_matrix(camera, file, numbers);
  } else if (count == 6) {
    constexpr double kLargestSide = 1e6;
    const auto is_side = [](double side) {
      return side >= 1 && side <= kLargestSide && side == std::floor(side);
    };
    if (!is_side(numbers[4]) || !is_side(numbers[5]))
      fail_camera(file, fmt::format("of six numbers the last two are the width and height of the "
                                    "images; {} x {} is no size in pixels",
                                    numbers[4], numbers[5]));
    set_pinhole(camera, numbers);
    camera.size = {static_cast<int>(numbers[4]), static_cast<int>(numbers[5])};
  } else if (count == 4 || count == 8 || count == 9 || count == 12) {
    set_pinhole(camera, numbers);
    camera.distortion.assign(numbers.begin() + 4, numbers.end());
  } else {
    fail_camera(
        file,
        fmt::format(
            "expected fx fy cx cy [k1 k2 p1 p2 [k3 [k4 k5 k6]]], fx fy cx cy "
            "width height or a 3 x 3 or 4 x 4 matrix, that is 4, 6, 8, 9, 12 or 16 numbers, got {}",
            count));
  }
  return camera;
}

[[noreturn]] void fail_at(const path& file, const toml::source_region& where,
                          const std::string& reason) {
  throw Error(ErrorCode::kCalibration,
              fmt::format("{}:{}: {}", file.string(), where.begin.line, reason));
}

// 0 if it is not there and need not be.
double number_in(const toml::table& table, std::string_view key, bool is_needed, const path& file) {
  const toml::node* const node = table.get(key);
  if (node == nullptr && !is_needed) return 0.0;
  if (node == nullptr) fail_camera(file, fmt::format("{} is missing", key));
  if (!node->is_number()) fail_at(file, node->source(), fmt::format("{} must be a number", key));
  return *node->value<double>();
}

int side_in(const toml::table& table, std::string_view key, const path& file) {
  constexpr double kLargestSide = 1e6;
  const double value = number_in(table, key, false, file);
  if (!(value >= 0 && value <= kLargestSide) || value != std::floor(value))
    fail_camera(file, fmt::format("{} = {} is no size in pixels", key, value));
  return static_cast<int>(value);
}

std::vector<double> coefficients_in(const toml::node& node, const path& file) {
  const toml::array* const values = node.as_array();
  if (values == nullptr)
    fail_at(file, node.source(), "distortion must be an array of numbers: k1, k2, p1, p2, k3");
  std::vector<double> coefficients;
  for (const toml::node& value : *values) {
    if (!value.is_number()) fail_at(file, value.source(), "distortion must be an array of numbers");
    coefficients.push_back(*value.value<double>());
  }
  return coefficients;
}

StatedCamera parse_camera_toml(const path& file, std::string_view text) {
  const toml::table table = parse_toml(text, file.string(), ErrorCode::kCalibration);
  StatedCamera camera{.fx = number_in(table, "fx", true, file),
                      .fy = number_in(table, "fy", true, file),
                      .cx = number_in(table, "cx", true, file),
                      .cy = number_in(table, "cy", true, file),
                      .distortion = {},
                      .size = {side_in(table, "width", file), side_in(table, "height", file)}};
  if (table.contains("depth_scale")) {
    camera.depth_scale = number_in(table, "depth_scale", true, file);
    camera.depth_scale_key = "depth_scale";
  }
  for (const auto& [key, node] : table) {
    if (key.str() == "distortion") {
      camera.distortion = coefficients_in(node, file);
    } else if (key.str() == "distortion_model") {
      const auto lens = lens_model(node.value_or(std::string("no text")));
      if (!lens)
        fail_at(file, node.source(),
                fmt::format("distortion_model must be one of {}", lens_model_names()));
      camera.lens = *lens;
    } else if (constexpr std::array kKnown = {"fx", "fy", "cx", "cy", "width", "height",
                                              "depth_scale"};
               std::ranges::find(kKnown, key.str()) == kKnown.end()) {
      fail_at(file, key.source(),
              fmt::format("unknown key {}; known are {}, distortion and distortion_model",
                          printable(key.str()), fmt::join(kKnown, ", ")));
    }
  }
  return camera;
}

StatedCamera parse_camera(const path& file, std::string_view text) {
  const std::string content = significant(text);
  if (content.empty()) fail_camera(file, fmt::format("empty, expected {}", kFormats));
  if (const auto numbers = as_numbers(content)) return camera_of_numbers(file, *numbers);
  const std::string_view first_line = std::string_view(content).substr(0, content.find('\n'));
  if (first_line.front() == '<')
    fail_camera(file, fmt::format("XML is not read, expected {}", kFormats));
  if (first_line.front() == '{') return parse_camera_json(file, text);
  const std::size_t sign = first_line.find_first_of("=:");
  const bool is_toml =
      first_line.front() == '[' || (sign != std::string_view::npos && first_line[sign] == '=');
  return is_toml ? parse_camera_toml(file, text) : parse_camera_yaml(file, text);
}

constexpr std::size_t kFewestCoefficients = 4;

std::size_t most_coefficients(LensModel lens) {
  return lens == LensModel::kEquidistant ? 4 : 8;
}

// Whether coefficients that the model does not have are not zero.
bool has_surplus(const StatedCamera& camera) {
  const auto& k = camera.distortion;
  const std::size_t known = std::min(k.size(), most_coefficients(camera.lens));
  return std::any_of(k.begin() + static_cast<std::ptrdiff_t>(known), k.end(),
                     [](double value) { return value != 0; });
}

// Distances in images: a principal point farther out, or a focal length shorter or longer than
// these, belongs to no camera of this kind, but to numbers in other units or another order.
constexpr double kFarthestPrincipalPoint = 0.5;
constexpr double kShortestFocalLength = 0.1;
constexpr double kLongestFocalLength = 100;

// Calibrations write zeros after what their model has; anything else is another model. Only the
// surplus of an equidistant lens is passed over (see camera_file_warning()): programs that know one
// name for both models write eight coefficients under it.
void set_distortion(DistortedCamera& camera, const path& file, const StatedCamera& stated) {
  const auto& k = stated.distortion;
  const bool is_equidistant = stated.lens == LensModel::kEquidistant;
  const std::size_t known = std::min(k.size(), most_coefficients(stated.lens));
  if ((!k.empty() && k.size() < kFewestCoefficients) || (!is_equidistant && has_surplus(stated)))
    fail_camera(file, fmt::format("distortion [{}] is not of the form {}; other models are not "
                                  "supported",
                                  fmt::join(k, ", "),
                                  is_equidistant ? "k1 k2 k3 k4" : "k1 k2 p1 p2 [k3 [k4 k5 k6]]"));
  std::copy_n(k.begin(), known, camera.distortion.begin());
  camera.lens = stated.lens;
}

}  // namespace

void fail_camera(const path& file, std::string_view reason) {
  throw Error(ErrorCode::kCalibration, fmt::format("{}: {}", file.string(), reason));
}

std::optional<LensModel> lens_model(std::string_view name) {
  for (const char* const known : {"", "plumb_bob", "radtan", "rational_polynomial"})
    if (name == known) return LensModel::kPolynomial;
  for (const char* const known : {"equidistant", "fisheye", "kannala_brandt"})
    if (name == known) return LensModel::kEquidistant;
  return std::nullopt;
}

std::string_view lens_model_names() {
  return "plumb_bob, radtan, rational_polynomial, equidistant, fisheye, kannala_brandt";
}

void set_matrix(StatedCamera& camera, const path& file, std::span<const double> m) {
  if (m.size() != 9)
    fail_camera(file, fmt::format("the camera matrix has {} numbers instead of 9", m.size()));
  if (m[1] != 0 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1)
    fail_camera(file, fmt::format("the camera matrix [{}] is not of the form fx 0 cx 0 fy cy 0 0 1",
                                  fmt::join(m, ", ")));
  camera.fx = m[0];
  camera.cx = m[2];
  camera.fy = m[4];
  camera.cy = m[5];
}

DistortedCamera read_camera(const path& file, cv::Size image_size) {
  const StatedCamera stated = parse_camera(file, read_text(file));
  if (!stated.size.empty() && !image_size.empty() && stated.size != image_size)
    fail_camera(file,
                fmt::format("calibrated for images of {} x {} px, but they have {} x {} px; if "
                            "they were only resized, --camera-size {}x{} scales it",
                            stated.size.width, stated.size.height, image_size.width,
                            image_size.height, stated.size.width, stated.size.height));
  const cv::Size size = image_size.empty() ? stated.size : image_size;
  if (size.empty()) fail_camera(file, "does not say the size of the images (width, height)");

  DistortedCamera camera{.pinhole = {.fx = stated.fx,
                                     .fy = stated.fy,
                                     .cx = stated.cx,
                                     .cy = stated.cy,
                                     .width = size.width,
                                     .height = size.height}};
  set_distortion(camera, file, stated);
  require_possible(file, camera);
  return camera;
}

void require_possible(const path& file, const DistortedCamera& camera) {
  const Camera& pinhole = camera.pinhole;
  if (pinhole.width <= 0 || pinhole.height <= 0)
    fail_camera(file, fmt::format("{} x {} is no size of an image", pinhole.width, pinhole.height));
  const auto check = [&](const char* name, double value, bool is_right, const std::string& need) {
    if (!std::isfinite(value) || !is_right)
      fail_camera(file, fmt::format("{} = {} {}", name, value, need));
  };
  const double width = pinhole.width, height = pinhole.height;
  const auto is_focal = [&](double f) {
    return f >= kShortestFocalLength * width && f <= kLongestFocalLength * width;
  };
  const auto is_near = [&](double c, double side) {
    return c >= -kFarthestPrincipalPoint * side && c <= (1 + kFarthestPrincipalPoint) * side;
  };
  const std::string focal =
      fmt::format("is no focal length in pixels of a {} px wide image", width);
  check("fx", pinhole.fx, is_focal(pinhole.fx), focal);
  check("fy", pinhole.fy, is_focal(std::abs(pinhole.fy)), focal);
  const std::string centre = fmt::format("is far outside of an image of {} x {} px", width, height);
  check("cx", pinhole.cx, is_near(pinhole.cx, width), centre);
  check("cy", pinhole.cy, is_near(pinhole.cy, height), centre);
  for (const double k : camera.distortion)
    check("distortion coefficient", k, true, "is not finite");
}

std::optional<StatedDepthScale> stated_depth_scale(const path& file) {
  StatedCamera camera;
  try {
    camera = parse_camera(file, read_text(file));
  } catch (const Error&) {
    return std::nullopt;
  }
  if (!camera.depth_scale) return std::nullopt;
  if (!std::isfinite(*camera.depth_scale) || *camera.depth_scale <= 0)
    fail_camera(file, fmt::format("{} = {} is no number of depth units per metre",
                                  camera.depth_scale_key, *camera.depth_scale));
  return StatedDepthScale{*camera.depth_scale, camera.depth_scale_key};
}

std::optional<std::string> camera_file_warning(const path& file) {
  const StatedCamera camera = parse_camera(file, read_text(file));
  if (camera.lens != LensModel::kEquidistant || !has_surplus(camera)) return std::nullopt;
  return fmt::format(
      "{}: an equidistant lens has 4 coefficients, the other {} are passed over; if it is a "
      "rational polynomial, say so: distortion_model: rational_polynomial",
      file.string(), camera.distortion.size() - most_coefficients(camera.lens));
}

std::string camera_to_toml(const DistortedCamera& camera) {
  const Camera& pinhole = camera.pinhole;
  return fmt::format(
      "# Pixel centres are integers; the lens model's coefficients are in OpenCV's order.\n"
      "width = {}\nheight = {}\nfx = {}\nfy = {}\ncx = {}\ncy = {}\n"
      "distortion_model = \"{}\"\ndistortion = [{}]\n",
      pinhole.width, pinhole.height, pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy,
      distortion_model(camera), fmt::join(distortion_coefficients(camera), ", "));
}

}  // namespace edvo
