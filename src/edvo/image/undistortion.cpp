// SPDX-License-Identifier: MIT
#include "edvo/image/undistortion.hpp"

#include "edvo/core/error.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace edvo {
namespace {

using simd::Int8;

// Where the ideal pixel (u, v) lies in the distorted image, [px].
cv::Vec2f source_of(const DistortedCamera& camera, double u, double v) {
  const Camera& c = camera.pinhole;
  const Eigen::Vector2d at = distort(camera, {(u - c.cx) / c.fx, (v - c.cy) / c.fy});
  const cv::Vec2f source(static_cast<float>(c.fx * at.x() + c.cx),
                         static_cast<float>(c.fy * at.y() + c.cy));
  // A rational polynomial may be 0 / 0 far outside of what was calibrated.
  constexpr cv::Vec2f::value_type kNowhere = -1e4F;
  return std::isfinite(source[0]) && std::isfinite(source[1]) ? source
                                                              : cv::Vec2f(kNowhere, kNowhere);
}

constexpr int kUnit = 32;  // of the fractions of a pixel, as in OpenCV
constexpr int kRound = kUnit * kUnit / 2;

// The interpolated byte: exact in integers, so that every machine has the same.
inline int interpolate(const std::uint8_t* p, int channels, int stride, int right, int down) {
  const int top = p[0] * (kUnit - right) + p[channels] * right;
  const int bottom = p[stride] * (kUnit - right) + p[stride + channels] * right;
  return (top * (kUnit - down) + bottom * down + kRound) / (kUnit * kUnit);
}

// Each pixel with the one below it in its high byte.
EDVO_CLONES void pair_rows(const std::uint8_t* row, const std::uint8_t* below, int width,
                           std::uint16_t* pairs) {
  for (int x = 0; x < width; ++x) pairs[x] = static_cast<std::uint16_t>(row[x] | (below[x] << 8));
}

// As interpolate() does, from pairs: two of them side by side are the four pixels around. count: a
// multiple of simd::kWidth.
EDVO_CLONES void undistort_eight(const std::uint16_t* pairs, const std::int32_t* corner,
                                 const std::uint8_t* right, const std::uint8_t* down,
                                 std::size_t count, std::uint8_t* out) {
  constexpr std::int32_t kEven = 0x00ff00ff;  // the upper two of the four, 16 bits apart
  for (std::size_t i = 0; i < count; i += simd::kWidth) {
    Int8 four, a, b;
    for (std::size_t k = 0; k < simd::kWidth; ++k) {
      std::int32_t word = 0;
      std::memcpy(&word, pairs + corner[i + k], sizeof word);
      four[k] = word;
      a[k] = right[i + k];
      b[k] = down[i + k];
    }
    // Left and right column in one multiplication: neither grows beyond 16 bits.
    const Int8 columns = (four & kEven) * (kUnit - b) + ((four >> 8) & kEven) * b;
    const Int8 value = ((columns & 0xffff) * (kUnit - a) + (columns >> 16) * a + kRound) >> 10;
    for (std::size_t k = 0; k < simd::kWidth; ++k) out[i + k] = static_cast<std::uint8_t>(value[k]);
  }
}

cv::Mat_<std::uint16_t> paired_rows(const cv::Mat& gray) {
  cv::Mat_<std::uint16_t> pairs(gray.rows - 1, gray.cols);
  for (int y = 0; y + 1 < gray.rows; ++y)
    pair_rows(gray.ptr(y), gray.ptr(y + 1), gray.cols, pairs[y]);
  return pairs;
}

}  // namespace

Undistortion make_undistortion(const DistortedCamera& camera) {
  const Camera& pinhole = camera.pinhole;
  if (pinhole.width <= 0 || pinhole.height <= 0 || pinhole.fx == 0 || pinhole.fy == 0)
    throw Error(ErrorCode::kCalibration, "camera: width, height, fx and fy must not be zero");
  const cv::Size size(pinhole.width, pinhole.height);
  Undistortion undistortion{.camera = pinhole,
                            .corner = {},
                            .right = {},
                            .down = {},
                            .nearest = {},
                            .valid = cv::Mat_<std::uint8_t>(size, std::uint8_t{255})};
  if (!is_distorted(camera) || size.width < 2 || size.height < 2) return undistortion;

  undistortion.corner.create(size);
  undistortion.right.create(size);
  undistortion.down.create(size);
  undistortion.nearest.create(size);
  const auto fixed = [](float at, int last) {
    return static_cast<int>(std::lrint(std::clamp(at, 0.F, static_cast<float>(last)) * kUnit));
  };
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const cv::Vec2f source = source_of(camera, x, y);
      const int u = fixed(source[0], size.width - 1), v = fixed(source[1], size.height - 1);
      const int column = std::min(u / kUnit, size.width - 2);
      const int row = std::min(v / kUnit, size.height - 2);
      undistortion.corner(y, x) = row * size.width + column;
      undistortion.right(y, x) = static_cast<std::uint8_t>(u - column * kUnit);
      undistortion.down(y, x) = static_cast<std::uint8_t>(v - row * kUnit);
      const cv::Point nearest(cv::saturate_cast<short>(source[0]),
                              cv::saturate_cast<short>(source[1]));
      undistortion.nearest(y, x) =
          nearest.inside({{0, 0}, size}) ? nearest.y * size.width + nearest.x : -1;
      const bool inside = source[0] >= 1.F && source[1] >= 1.F &&
                          source[0] <= static_cast<float>(size.width - 2) &&
                          source[1] <= static_cast<float>(size.height - 2);
      if (!inside) undistortion.valid(y, x) = 0;
    }
  return undistortion;
}

cv::Mat undistort_colour(const Undistortion& undistortion, const cv::Mat& image) {
  if (undistortion.corner.empty()) return image;
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  cv::Mat result(image.size(), image.type());
  const int channels = image.channels(), stride = image.cols * channels;
  const std::int32_t* corner = undistortion.corner[0];
  const std::uint8_t *right = undistortion.right[0], *down = undistortion.down[0];
  const std::uint8_t* in = whole.ptr();
  std::uint8_t* out = result.ptr();
  const std::size_t count = image.total();
  std::size_t i = 0;
  if (channels == 1) {
    i = count / simd::kWidth * simd::kWidth;
    undistort_eight(paired_rows(whole)[0], corner, right, down, i, out);
  }
  for (; i < count; ++i)
    for (int c = 0; c < channels; ++c)
      out[i * channels + c] = static_cast<std::uint8_t>(
          interpolate(in + corner[i] * channels + c, channels, stride, right[i], down[i]));
  return result;
}

}  // namespace edvo
