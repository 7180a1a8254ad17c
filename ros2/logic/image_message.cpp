// SPDX-License-Identifier: MIT
#include "logic/image_message.hpp"

#include "edvo/core/error.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace edvo::ros {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

void require_size(const ImageMessage& image, int bytes_per_pixel) {
  const auto row = static_cast<std::int64_t>(image.width) * bytes_per_pixel;
  const auto needed = static_cast<std::int64_t>(image.step) * image.height;
  if (image.width <= 0 || image.height <= 0 || image.step < row ||
      static_cast<std::int64_t>(image.data.size()) < needed)
    throw Error(ErrorCode::kInput,
                "image " + image.encoding + " of " + std::to_string(image.width) + " x " +
                    std::to_string(image.height) + " px: " + std::to_string(image.data.size()) +
                    " bytes, " + std::to_string(image.step) + " a row, are too few");
}

const std::uint8_t* row_of(const ImageMessage& image, int y) {
  return image.data.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(image.step);
}

template <typename T>
T number_at(const std::uint8_t* bytes, bool swap) {
  std::array<std::uint8_t, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes, sizeof(T));
  if (swap) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

struct Layout {
  int channels = 0;  // 0 = not known
  int red = 0, green = 0, blue = 0;
};

Layout layout_of(const std::string& encoding) {
  if (encoding == "rgb8") return {3, 0, 1, 2};
  if (encoding == "bgr8" || encoding == "8UC3") return {3, 2, 1, 0};
  if (encoding == "rgba8") return {4, 0, 1, 2};
  if (encoding == "bgra8") return {4, 2, 1, 0};
  if (encoding == "mono8" || encoding == "8UC1") return {1, 0, 0, 0};
  return {};
}

}  // namespace

cv::Mat_<cv::Vec3b> to_bgr(const ImageMessage& image) {
  const Layout layout = layout_of(image.encoding);
  if (layout.channels == 0)
    throw Error(ErrorCode::kInput,
                "colour of encoding " + image.encoding +
                    ": not read; known are rgb8, bgr8, rgba8, bgra8, mono8");
  require_size(image, layout.channels);
  cv::Mat_<cv::Vec3b> bgr(image.height, image.width);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* pixel = row_of(image, y);
    for (int x = 0; x < image.width; ++x, pixel += layout.channels)
      bgr(y, x) = {pixel[layout.blue], pixel[layout.green], pixel[layout.red]};
  }
  return bgr;
}

cv::Mat_<float> to_metres(const ImageMessage& image, double units_per_metre) {
  const bool is_float = image.encoding == "32FC1";
  if (!is_float && image.encoding != "16UC1" && image.encoding != "mono16")
    throw Error(ErrorCode::kInput, "depth of encoding " + image.encoding +
                                       ": not read; known are 16UC1, mono16, 32FC1");
  const int bytes = is_float ? 4 : 2;
  require_size(image, bytes);
  const bool swap = image.is_bigendian != (std::endian::native == std::endian::big);
  const auto units = static_cast<float>(units_per_metre);
  cv::Mat_<float> depth(image.height, image.width);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* pixel = row_of(image, y);
    for (int x = 0; x < image.width; ++x, pixel += bytes) {
      if (is_float) {
        const auto z = number_at<float>(pixel, swap);
        depth(y, x) = std::isfinite(z) && z > 0 ? z : kNone;
      } else {
        const auto z = number_at<std::uint16_t>(pixel, swap);
        const bool is_known = z != 0 && z != std::numeric_limits<std::uint16_t>::max();
        depth(y, x) = is_known ? static_cast<float>(z) / units : kNone;
      }
    }
  }
  return depth;
}

DistortedCamera to_camera(int width, int height, std::span<const double, 9> k,
                          const std::string& distortion_model, std::span<const double> d) {
  if (!(k[0] > 0))
    throw Error(ErrorCode::kCalibration,
                "CameraInfo: no focal length (the camera was not calibrated)");
  DistortedCamera camera{.pinhole = {.fx = k[0],
                                     .fy = k[4],
                                     .cx = k[2],
                                     .cy = k[5],
                                     .width = width,
                                     .height = height}};
  const bool is_equidistant = distortion_model == "equidistant" || distortion_model == "fisheye";
  const bool is_polynomial = distortion_model.empty() || distortion_model == "plumb_bob" ||
                             distortion_model == "rational_polynomial";
  const std::size_t most = is_equidistant ? 4 : 8;
  const auto is_zero = [](double value) { return value == 0; };
  const std::size_t known = std::min(most, d.size());
  const bool is_given = !std::ranges::all_of(d, is_zero);
  if (is_given && ((!is_equidistant && !is_polynomial) ||
                   !std::ranges::all_of(d.subspan(known), is_zero)))
    throw Error(ErrorCode::kCalibration,
                "CameraInfo: distortion model " + distortion_model + " with " +
                    std::to_string(d.size()) + " coefficients is not known");
  if (is_equidistant) camera.lens = LensModel::kEquidistant;
  if (is_given || is_equidistant)
    std::copy_n(d.begin(), known, camera.distortion.begin());
  return camera;
}

}  // namespace edvo::ros
