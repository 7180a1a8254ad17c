// SPDX-License-Identifier: MIT
#include "edvo/io/occupancy_file.hpp"

#include "edvo/io/output_file.hpp"

#include <fmt/core.h>

#include <string>

namespace edvo {
namespace {

// Values of map_server's own saver, which its thresholds below tell apart.
char gray_of(CellState state) {
  constexpr unsigned char kOccupied = 0, kFree = 254, kUnknown = 205;
  return static_cast<char>(state == CellState::kOccupied ? kOccupied
                           : state == CellState::kFree   ? kFree
                                                         : kUnknown);
}

std::string pgm_of(const OccupancyGrid& grid) {
  const cv::Mat_<std::uint8_t>& cells = grid.cells;
  std::string bytes = fmt::format("P5\n{} {}\n255\n", cells.cols, cells.rows);
  for (int y = cells.rows - 1; y >= 0; --y)  // the image's first row is the farthest
    for (int x = 0; x < cells.cols; ++x)
      bytes.push_back(gray_of(static_cast<CellState>(cells(y, x))));
  return bytes;
}

// YAML's double quotes take any name.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (static_cast<unsigned char>(c) < ' ')
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      result += c;
  }
  return result + '"';
}

std::string yaml_of(const OccupancyGrid& grid, const std::string& image) {
  const Eigen::Vector3d& t = grid.grid_from_map.translation;
  const Eigen::Quaterniond& q = grid.grid_from_map.rotation;
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {:.6g}\norigin: [{:.6f}, {:.6f}, 0.0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
      "# grid_from_map, the map's frame being that of its trajectory: tx ty tz qx qy qz qw\n"
      "# {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
      quoted(image), grid.resolution, grid.origin.x(), grid.origin.y(), t.x(), t.y(), t.z(), q.x(),
      q.y(), q.z(), q.w());
}

}  // namespace

void write_occupancy(const std::filesystem::path& file, const OccupancyGrid& grid) {
  write_whole(file, pgm_of(grid));
  std::filesystem::path yaml = file;
  write_whole(yaml.replace_extension(".yaml"), yaml_of(grid, file.filename().string()));
}

}  // namespace edvo
