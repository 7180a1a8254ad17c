// SPDX-License-Identifier: MIT
#include "edvo/io/ply_file.hpp"

#include "edvo/io/output_file.hpp"

#include <fmt/core.h>

#include <bit>
#include <string>

namespace edvo {
namespace {

void append_little_endian(std::string& bytes, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (int shift = 0; shift < 32; shift += 8)
    bytes.push_back(static_cast<char>(bits >> shift & 0xFF));
}

}  // namespace

void write_ply(const std::filesystem::path& file, std::span<const ColoredPoint> points) {
  constexpr std::size_t kBytesPerPoint = 15;
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      points.size());
  bytes.reserve(bytes.size() + kBytesPerPoint * points.size());
  for (const ColoredPoint& point : points) {
    for (int i = 0; i < 3; ++i) append_little_endian(bytes, point.position[i]);
    for (const std::uint8_t channel : point.rgb) bytes.push_back(static_cast<char>(channel));
  }
  write_whole(file, bytes);
}

}  // namespace edvo
