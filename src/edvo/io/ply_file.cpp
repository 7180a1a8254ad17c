// SPDX-License-Identifier: MIT
#include "edvo/io/ply_file.hpp"

#include "edvo/io/byte_codec.hpp"
#include "edvo/io/output_file.hpp"

#include <fmt/core.h>

#include <string>

namespace edvo {
namespace {

std::string head_of(std::size_t vertices) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n",
      vertices);
}

void append_vertices(std::string& bytes, std::span<const ColoredPoint> points) {
  constexpr std::size_t kBytesPerPoint = 15;
  bytes.reserve(bytes.size() + kBytesPerPoint * points.size());
  for (const ColoredPoint& point : points) {
    for (int i = 0; i < 3; ++i) append_number(bytes, point.position[i]);
    for (const std::uint8_t channel : point.rgb) bytes.push_back(static_cast<char>(channel));
  }
}

}  // namespace

void write_ply(const std::filesystem::path& file, std::span<const ColoredPoint> points) {
  std::string bytes = head_of(points.size()) + "end_header\n";
  append_vertices(bytes, points);
  write_whole(file, bytes);
}

void write_mesh(const std::filesystem::path& file, const Mesh& mesh) {
  constexpr std::size_t kBytesPerTriangle = 13;
  std::string bytes = head_of(mesh.vertices.size()) +
                      fmt::format(
                          "element face {}\nproperty list uchar int vertex_indices\n"
                          "end_header\n",
                          mesh.triangles.size());
  append_vertices(bytes, mesh.vertices);
  bytes.reserve(bytes.size() + kBytesPerTriangle * mesh.triangles.size());
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    bytes.push_back(3);
    for (const std::uint32_t vertex : triangle) append_number(bytes, vertex);
  }
  write_whole(file, bytes);
}

}  // namespace edvo
