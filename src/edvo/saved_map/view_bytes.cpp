// SPDX-License-Identifier: MIT
#include "edvo/saved_map/view_bytes.hpp"

#include "edvo/io/byte_codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace edvo {
namespace {

constexpr std::size_t kPointBytes = 3 * sizeof(float);

// What a pixel is expected to be, from those to its left, above, and above to the left.
template <typename Value>
Value predict(Value left, Value above, Value corner) {
  if (corner >= std::max(left, above)) return std::min(left, above);
  if (corner <= std::min(left, above)) return std::max(left, above);
  return static_cast<Value>(left + above - corner);
}

// Of a channel of an image; pixels outside count as 0.
template <typename Value>
Value prediction(const Value* row, const Value* above, int x, int step) {
  const Value left = x > 0 ? row[(x - 1) * step] : Value{0};
  if (above == nullptr) return left;
  return predict(left, above[x * step], x > 0 ? above[(x - 1) * step] : Value{0});
}

// An image of 8 or 16 bits; step: its channels, of which the first is meant.
template <typename Value>
struct Channel {
  Value* data = nullptr;
  int rows = 0, cols = 0, step = 1;

  [[nodiscard]] Value* row(int y) const { return y < 0 ? nullptr : data + y * cols * step; }
};

// High bytes, if there are any, come after all low ones.
template <typename Value>
void append_channel(std::string& bytes, const Channel<const Value>& image) {
  const std::size_t start = bytes.size(), count = static_cast<std::size_t>(image.rows * image.cols);
  bytes.resize(start + count * sizeof(Value));
  char* out = bytes.data() + start;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x, ++out) {
      const auto rest =
          static_cast<Value>(image.row(y)[x * image.step] -
                             prediction<Value>(image.row(y), image.row(y - 1), x, image.step));
      *out = static_cast<char>(rest & 0xFF);
      if constexpr (sizeof(Value) == 2) out[count] = static_cast<char>(rest >> 8);
    }
}

template <typename Value>
void take_channel(ByteReader& reader, const Channel<Value>& image) {
  const std::size_t count = static_cast<std::size_t>(image.rows * image.cols);
  const std::string_view bytes = reader.bytes(count * sizeof(Value));
  if (bytes.empty()) return;
  const auto* in = reinterpret_cast<const unsigned char*>(bytes.data());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x, ++in) {
      unsigned rest = *in;
      if constexpr (sizeof(Value) == 2) rest |= static_cast<unsigned>(in[count]) << 8;
      image.row(y)[x * image.step] = static_cast<Value>(
          rest + prediction<Value>(image.row(y), image.row(y - 1), x, image.step));
    }
}

template <typename Value, typename Image>
Channel<Value> channel_of(Image& image, int channel = 0) {
  return {.data = reinterpret_cast<Value*>(image.data) + channel,
          .rows = image.rows,
          .cols = image.cols,
          .step = image.channels()};
}

// Coordinate by coordinate, byte by byte.
void append_points(std::string& bytes, const std::vector<Eigen::Vector3f>& points) {
  for (int axis = 0; axis < 3; ++axis)
    for (int shift = 0; shift < 32; shift += 8)
      for (const Eigen::Vector3f& point : points)
        bytes.push_back(
            static_cast<char>(std::bit_cast<std::uint32_t>(point[axis]) >> shift & 0xFF));
}

std::vector<Eigen::Vector3f> take_points(ByteReader& reader, std::size_t count) {
  const std::string_view bytes = reader.bytes(count * kPointBytes);
  std::vector<Eigen::Vector3f> points(bytes.empty() ? 0 : count);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t bits = 0;
      for (std::size_t byte = 0; byte < 4; ++byte)
        bits |= static_cast<std::uint32_t>(
                    static_cast<unsigned char>(bytes[(4 * axis + byte) * count + i]))
                << (8 * byte);
      points[i][static_cast<Eigen::Index>(axis)] = std::bit_cast<float>(bits);
    }
  return points;
}

bool is_in_view(const Eigen::Vector3f& point, const Camera& camera) {
  if (!point.allFinite() || !(point.z() > 0)) return false;
  const Eigen::Vector2d pixel = project(camera, point.cast<double>());
  constexpr double kHalf = 0.5;
  return pixel.x() > -kHalf && pixel.y() > -kHalf && pixel.x() < camera.width - kHalf &&
         pixel.y() < camera.height - kHalf;
}

cv::Size half_of(const cv::Size& size) {
  return {(size.width + 1) / 2, (size.height + 1) / 2};
}

template <typename Image>
Image whole(const Image& image) {
  return image.isContinuous() ? image : Image(image.clone());
}

}  // namespace

std::string encode_view(const Place& view) {
  const cv::Mat_<std::uint8_t> gray = whole(view.gray);
  const cv::Mat_<std::uint16_t> depth = whole(view.half_depth);
  const cv::Mat_<cv::Vec2b> chroma = whole(view.half_chroma);
  std::string bytes;
  append_number(bytes, view.id);
  append_number(bytes, static_cast<std::uint32_t>(view.points.size()));
  append_number(bytes, std::uint32_t{chroma.empty() ? 0U : 1U});
  append_channel(bytes, channel_of<const std::uint8_t>(gray));
  append_channel(bytes, channel_of<const std::uint16_t>(depth));
  if (!chroma.empty())
    for (const int c : {0, 1}) append_channel(bytes, channel_of<const std::uint8_t>(chroma, c));
  append_points(bytes, view.points);
  return bytes;
}

std::optional<Place> decode_view(std::string_view bytes, const Camera& camera) {
  const cv::Size size(camera.width, camera.height), half = half_of(size);
  ByteReader reader(bytes);
  Place view{.id = reader.number<std::int64_t>()};
  const auto points = reader.number<std::uint32_t>();
  const auto colour = reader.number<std::uint32_t>();
  if (!reader.ok() || colour > 1) return std::nullopt;
  const std::uint64_t expected = static_cast<std::uint64_t>(size.area()) +
                                 (2 + 2 * colour) * static_cast<std::uint64_t>(half.area()) +
                                 std::uint64_t{points} * kPointBytes;
  if (reader.left() != expected) return std::nullopt;
  view.gray.create(size);
  view.half_depth.create(half);
  take_channel(reader, channel_of<std::uint8_t>(view.gray));
  take_channel(reader, channel_of<std::uint16_t>(view.half_depth));
  if (colour == 1) {
    view.half_chroma.create(half);
    for (const int c : {0, 1}) take_channel(reader, channel_of<std::uint8_t>(view.half_chroma, c));
  }
  view.points = take_points(reader, points);
  if (!std::all_of(view.points.begin(), view.points.end(),
                   [&](const Eigen::Vector3f& p) { return is_in_view(p, camera); }))
    return std::nullopt;
  return view;
}

}  // namespace edvo
