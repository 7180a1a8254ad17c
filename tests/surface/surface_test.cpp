// SPDX-License-Identifier: MIT
#include "edvo/surface/make_grid.hpp"
#include "edvo/surface/surface_nets.hpp"
#include "edvo/synth/rays.hpp"
#include "edvo/synth/render.hpp"
#include "support/rendered_sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace edvo {
namespace {

DepthView view_of(const RgbdImage& image, const SE3& pose) {
  DepthView view{.camera = test::kQvgaCamera,
                 .world_from_camera = pose,
                 .depth = image.depth,
                 .rgb = cv::Mat_<cv::Vec3b>(image.bgr)};
  return view;
}

// A furnished room, seen by a Kinect with all its noise from every second pixel of 640 x 480.
struct Room {
  synth::SyntheticSequence sequence;
  std::vector<DepthView> views;
};

Room make_room(synth::SceneName scene, int frames) {
  Room room{.sequence = test::make_sequence({.scene = scene,
                                             .path = synth::PathName::kOrbit,
                                             .seed = 3,
                                             .frames = frames,
                                             .rate = 3,
                                             .sensor = {}},
                                            test::kQvgaCamera),
            .views = {}};
  for (int i = 0; i < synth::frame_count(room.sequence); ++i)
    room.views.push_back(view_of(synth::make_frame(room.sequence, i),
                                 synth::pose_of(room.sequence, i).world_from_camera));
  return room;
}

const Room& office() {
  static const Room kRoom = make_room(synth::SceneName::kOffice, 40);
  return kRoom;
}

Mesh mesh_of(const std::vector<DepthView>& views, int threads) {
  TsdfVolume volume({});
  for (const DepthView& view : views) volume.integrate(view, threads);
  return extract_mesh(volume);
}

double quantile(std::vector<double> values, double share) {
  const auto nth =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

TEST(Surface, MeshOfARenderedRoomIsWithinFiveMillimetresOfIt) {
  for (const auto scene : {synth::SceneName::kOffice, synth::SceneName::kLivingRoom}) {
    const Room room = scene == synth::SceneName::kOffice ? office() : make_room(scene, 40);
    const Mesh mesh = mesh_of(room.views, 2);
    ASSERT_GT(mesh.triangles.size(), 50'000u);
    std::vector<double> distances;
    for (const ColoredPoint& vertex : mesh.vertices)
      distances.push_back(
          std::abs(synth::clearance(room.sequence.scene, vertex.position.cast<double>())));
    const double median = quantile(distances, 0.5), most = quantile(distances, 0.95);
    RecordProperty(std::string(name_of(scene)) + "_median_mm", std::to_string(1000 * median));
    RecordProperty(std::string(name_of(scene)) + "_95_percent_mm", std::to_string(1000 * most));
    EXPECT_LT(median, 0.005);
    EXPECT_LT(most, 0.020);
  }
}

// The mesh has what the camera saw: most measured points of the last view lie on it.
TEST(Surface, MeshLeavesLittleOut) {
  const Mesh mesh = mesh_of(office().views, 2);
  constexpr double kCell = 0.03;
  const auto cell_of = [kCell](const Eigen::Vector3d& p) {
    const Eigen::Vector3i cell = (p / kCell).array().floor().cast<int>();
    return std::array<int, 3>{cell.x(), cell.y(), cell.z()};
  };
  std::vector<std::array<int, 3>> cells;
  for (const ColoredPoint& vertex : mesh.vertices)
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz)
          cells.push_back(
              cell_of(vertex.position.cast<double>() + kCell * Eigen::Vector3d(dx, dy, dz)));
  std::sort(cells.begin(), cells.end());
  const DepthView& view = office().views.back();
  int all = 0, covered = 0;
  for (int y = 2; y < view.depth.rows; y += 5)
    for (int x = 2; x < view.depth.cols; x += 5) {
      const float z = view.depth(y, x);
      if (!(z > 0) || z > 4) continue;
      ++all;
      const Eigen::Vector3d point =
          view.world_from_camera * back_project(view.camera, x, y, static_cast<double>(z));
      if (std::binary_search(cells.begin(), cells.end(), cell_of(point))) ++covered;
    }
  EXPECT_GT(covered, 0.95 * all);
}

TEST(Surface, MeshHasTheSameBitsWithAnyNumberOfThreads) {
  const std::vector<DepthView> views(office().views.begin(), office().views.begin() + 5);
  const Mesh a = mesh_of(views, 1), b = mesh_of(views, 3);
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  EXPECT_EQ(a.triangles, b.triangles);
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    ASSERT_EQ(a.vertices[i].position, b.vertices[i].position);
    ASSERT_EQ(a.vertices[i].rgb, b.vertices[i].rgb);
  }
}

// A wall across the view, one metre away.
DepthView wall() {
  const cv::Size size(320, 240);
  return {.camera = test::kQvgaCamera,
          .world_from_camera = {},
          .depth = cv::Mat_<float>(size, 1.F),
          .rgb = cv::Mat_<cv::Vec3b>(size, cv::Vec3b(200, 100, 50))};
}

TEST(Surface, TrianglesOfAWallFaceTheCameraWithItsColour) {
  const Mesh mesh = mesh_of({wall()}, 1);
  ASSERT_GT(mesh.triangles.size(), 10'000u);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f u = mesh.vertices[b].position - mesh.vertices[a].position;
    const Eigen::Vector3f v = mesh.vertices[c].position - mesh.vertices[a].position;
    ASSERT_LT(u.cross(v).z(), 0);
  }
  for (const ColoredPoint& vertex : mesh.vertices) {
    ASSERT_NEAR(vertex.position.z(), 1, 1e-4);
    ASSERT_EQ(vertex.rgb, (std::array<std::uint8_t, 3>{200, 100, 50}));
  }
}

TEST(Surface, RefusesMoreBlocksThanAllowed) {
  TsdfVolume volume({.max_blocks = 10});
  EXPECT_THROW(volume.integrate(wall(), 1), Error);
}

TEST(Floor, IsFoundWithTheDirectionUp) {
  for (const auto scene :
       {synth::SceneName::kOffice, synth::SceneName::kLivingRoom, synth::SceneName::kCorridor}) {
    const Room room = make_room(scene, 6);
    const std::optional<Floor> floor = find_floor(room.views, std::nullopt);
    ASSERT_TRUE(floor) << name_of(scene);
    EXPECT_LT(std::acos(std::min(1.0, floor->up.z())), 0.02) << name_of(scene);
    EXPECT_NEAR(floor->height, 0, 0.03) << name_of(scene);
  }
}

// How near to the middle of the cell a true surface is in the column above it [m].
double clearance_above(const Room& room, const OccupancyGrid& grid, int x, int y) {
  const Eigen::Vector2d middle = grid.origin + grid.resolution * Eigen::Vector2d(x + 0.5, y + 0.5);
  double nearest = 10;
  for (double z = 0.15; z < 1.45; z += 0.02) {
    const Eigen::Vector3d point(middle.x(), middle.y(), z);
    nearest = std::min(nearest,
                       synth::clearance(room.sequence.scene, inverse(grid.grid_from_map) * point));
  }
  return nearest;
}

// Tabletops count as all else: a robot does not fit below.
TEST(Grid, CellsAreFreeOrOccupiedAsTheRoomIs) {
  int free = 0, occupied = 0, wrongly_free = 0, wrongly_occupied = 0;
  for (const auto scene : {synth::SceneName::kOffice, synth::SceneName::kLivingRoom}) {
    const Room room = scene == synth::SceneName::kOffice ? office() : make_room(scene, 40);
    const OccupancyGrid grid = make_grid(room.views, {.up = Eigen::Vector3d::UnitZ(), .height = 0});
    for (int y = 0; y < grid.cells.rows; ++y)
      for (int x = 0; x < grid.cells.cols; ++x) {
        const auto state = static_cast<CellState>(grid.cells(y, x));
        if (state == CellState::kUnknown) continue;
        const double nearest = clearance_above(room, grid, x, y);
        if (state == CellState::kFree) {
          ++free;
          if (nearest < 0.011) ++wrongly_free;  // points are 0.02 m apart, so that none is missed
        } else {
          ++occupied;
          if (nearest > 0.1) ++wrongly_occupied;
        }
      }
  }
  EXPECT_GT(free, 1000);
  EXPECT_GT(occupied, 1000);
  EXPECT_LT(wrongly_free, 0.01 * free);
  EXPECT_LT(wrongly_occupied, 0.05 * occupied);
  RecordProperty("wrongly_free", wrongly_free);
}

// The camera looks straight down on a plate at 0.7 m that fills part of its image.
TEST(Grid, APlateAboveTheFloorIsAnObstacleInCellsOfAnySize) {
  cv::Mat_<float> depth(240, 320, 2.F);
  depth(cv::Rect(100, 80, 120, 80)) = 1.3F;
  const SE3 above{.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())),
                  .translation = {0, 0, 2}};
  const DepthView view{.camera = test::kQvgaCamera,
                       .world_from_camera = above,
                       .depth = depth,
                       .rgb = cv::Mat_<cv::Vec3b>(240, 320)};
  for (const double cell : {0.02, 0.05, 0.2}) {
    const OccupancyGrid grid = make_grid(
        std::span(&view, 1), {.up = Eigen::Vector3d::UnitZ(), .height = 0}, {.resolution = cell});
    const auto state_at = [&](const Eigen::Vector3d& point) {
      const Eigen::Array2d at =
          (((grid.grid_from_map * point).head<2>() - grid.origin) / cell).array().floor();
      return static_cast<CellState>(grid.cells(static_cast<int>(at.y()), static_cast<int>(at.x())));
    };
    EXPECT_EQ(state_at({0, 0, 0.7}), CellState::kOccupied) << cell;
    EXPECT_EQ(state_at({0.9, 0, 0}), CellState::kFree) << cell;
  }
}

}  // namespace
}  // namespace edvo
