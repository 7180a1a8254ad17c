// SPDX-License-Identifier: MIT
#include "edvo/io/occupancy_file.hpp"

#include "edvo/io/file.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

namespace edvo {
namespace {

OccupancyGrid some_grid() {
  OccupancyGrid grid{.resolution = 0.05, .origin = {-1.5, 2}, .cells = {}, .grid_from_map = {}};
  grid.cells.create(2, 3);
  grid.cells << 0, 1, 2, 1, 1, 0;
  return grid;
}

TEST(OccupancyFile, TheImageHasTheFarthestRowFirst) {
  const test::TemporaryFolder folder;
  write_occupancy(folder.path() / "room.pgm", some_grid());
  const std::string pixels = {'\xFE', '\xFE', '\xCD', '\xCD', '\xFE', '\x00'};
  EXPECT_EQ(read_file(folder.path() / "room.pgm"), "P5\n3 2\n255\n" + pixels);
}

// The keys that map_server reads, by a YAML reader like its own.
TEST(OccupancyFile, TheYamlFileSaysWhereTheImageLies) {
  const test::TemporaryFolder folder;
  write_occupancy(folder.path() / "a \"room\".pgm", some_grid());
  const YAML::Node yaml = YAML::LoadFile(folder.path() / "a \"room\".yaml");
  EXPECT_EQ(yaml["image"].as<std::string>(), "a \"room\".pgm");
  EXPECT_EQ(yaml["resolution"].as<double>(), 0.05);
  EXPECT_EQ(yaml["origin"].as<std::vector<double>>(), (std::vector<double>{-1.5, 2, 0}));
  EXPECT_EQ(yaml["negate"].as<int>(), 0);
  // Occupancy is (255 - pixel) / 255: free below the one threshold, occupied above the other.
  const double free = yaml["free_thresh"].as<double>();
  EXPECT_LT((255 - 254) / 255.0, free);
  EXPECT_GT((255 - 205) / 255.0, free);
  EXPECT_LT((255 - 205) / 255.0, yaml["occupied_thresh"].as<double>());
}

}  // namespace
}  // namespace edvo
