// SPDX-License-Identifier: MIT
// edvo map export: what other programs read of a map.
#include "map_verbs.hpp"

#include "edvo/io/occupancy_file.hpp"
#include "edvo/io/ply_file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/map_views.hpp"
#include "edvo/surface/make_grid.hpp"
#include "edvo/surface/surface_nets.hpp"
#include "option_checks.hpp"
#include "output_name.hpp"
#include "stop_signal.hpp"
#include "terminal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace edvo::app {
namespace {

struct Arguments {
  std::string map;
  std::string points, mesh, grid, trajectory;  // files, empty = not asked for
  std::optional<int> segment;
  std::vector<double> up;       // in the map's frame, empty = as the floor tells
  std::optional<double> floor;  // height along up [m], none = as the depth tells
  double max_depth = 4;         // [m]
  VolumeOptions volume;
  GridOptions cells;
  bool force = false;
  int threads = 2;
};

int chosen_segment(const Arguments& arguments, const SavedMap& map) {
  const std::vector<int> all = segments_of(map);
  if (!arguments.segment) {
    const int largest = largest_segment(map);
    if (all.size() > 1)
      say("edvo: the map has {} segments, between which no motion is known; taken is the largest, "
          "--segment {}\n",
          all.size(), largest);
    return largest;
  }
  if (std::find(all.begin(), all.end(), *arguments.segment) == all.end())
    throw Error(ErrorCode::kUsage, fmt::format("--segment {}: the map has {}", *arguments.segment,
                                               fmt::join(all, ", ")));
  return *arguments.segment;
}

void export_mesh(const Arguments& arguments, const std::vector<DepthView>& views) {
  TsdfVolume volume(arguments.volume);
  for (const DepthView& view : views) {
    if (stop_requested()) throw CLI::RuntimeError("interrupted", kInterruptedStatus);
    volume.integrate(view, arguments.threads);
  }
  const Mesh mesh = extract_mesh(volume);
  if (mesh.triangles.empty())
    throw Error(ErrorCode::kMap,
                fmt::format("--mesh {}: no surface is found with voxels of {} m; give a smaller "
                            "--voxel",
                            arguments.mesh, arguments.volume.voxel));
  write_mesh(arguments.mesh, mesh);
  print("{}: {} vertices, {} triangles\n", arguments.mesh, mesh.vertices.size(),
        mesh.triangles.size());
}

Floor floor_of(const Arguments& arguments, const std::vector<DepthView>& views) {
  std::optional<Eigen::Vector3d> up;
  if (!arguments.up.empty()) {
    up = Eigen::Vector3d(arguments.up[0], arguments.up[1], arguments.up[2]);
    if (!(up->norm() > 0) || !up->allFinite())
      throw Error(ErrorCode::kUsage, "--up: needs a direction of three numbers, not all 0");
    if (arguments.floor) return {.up = up->normalized(), .height = *arguments.floor};
  }
  std::optional<Floor> floor = find_floor(views, up);
  if (!floor)
    throw Error(ErrorCode::kMap,
                fmt::format("{}: no floor is seen in this map; say --up X Y Z and --floor METRES",
                            arguments.map));
  if (arguments.floor) floor->height = *arguments.floor;
  return *floor;
}

// A surface is missed between the points that were measured on it.
void warn_of_fine_cells(const Arguments& arguments, const std::vector<DepthView>& views) {
  double finest = 0;
  for (const DepthView& view : views)
    finest = std::max(finest, 1 / ray_density(view, arguments.max_depth));
  if (arguments.cells.resolution < finest)
    say("warning: --cell {}: finer than what the images show at {} m, so that obstacles may be "
        "missed; give --cell {:.3f} or more, or --max-depth {:.1f} or less\n",
        arguments.cells.resolution, arguments.max_depth, std::ceil(1000 * finest) / 1000,
        arguments.max_depth * arguments.cells.resolution / finest);
}

void export_grid(const Arguments& arguments, const std::vector<DepthView>& views) {
  warn_of_fine_cells(arguments, views);
  const Floor floor = floor_of(arguments, views);
  GridOptions options = arguments.cells;
  options.max_depth = arguments.max_depth;
  const OccupancyGrid grid = make_grid(views, floor, options);
  write_occupancy(arguments.grid, grid);
  print("{}: {} x {} cells of {} m; up is {:.4f} {:.4f} {:.4f}, the floor at {:.3f} m along it\n",
        arguments.grid, grid.cells.cols, grid.cells.rows, grid.resolution, floor.up.x(),
        floor.up.y(), floor.up.z(), floor.height);
}

// Of all segments, which the file tells apart, or of the one that was asked for.
void export_trajectory(const std::string& file, const SavedMap& map,
                       const std::optional<int>& segment) {
  Trajectory trajectory;
  for (const MapKeyframe& key : map.keyframes)
    if (!segment || key.segment == *segment)
      trajectory.push_back(
          {.stamp = key.stamp, .world_from_camera = key.world_from_camera, .segment = key.segment});
  write_trajectory(file, trajectory);
  print("{}: {} poses\n", file, trajectory.size());
}

// Before the map is read.
void require_writable_names(const Arguments& arguments) {
  require_distinct({{"--points", arguments.points},
                    {"--mesh", arguments.mesh},
                    {"--grid", arguments.grid},
                    {"--trajectory", arguments.trajectory}});
  require_ending("--points", arguments.points, {".ply"});
  require_ending("--mesh", arguments.mesh, {".ply"});
  require_ending("--grid", arguments.grid, {".pgm"});
  require_ending("--trajectory", arguments.trajectory, {".tum", ".txt"});
  require_new("--points", arguments.points, arguments.force);
  require_new("--mesh", arguments.mesh, arguments.force);
  require_new("--grid", arguments.grid, arguments.force);
  if (!arguments.grid.empty())
    require_new("--grid", std::filesystem::path(arguments.grid).replace_extension(".yaml").string(),
                arguments.force);
  require_new("--trajectory", arguments.trajectory, arguments.force);
}

void export_map(Arguments arguments) {
  if (arguments.points.empty() && arguments.mesh.empty() && arguments.grid.empty() &&
      arguments.trajectory.empty())
    throw Error(ErrorCode::kUsage,
                "map export: nothing to write; give --points, --mesh, --grid or --trajectory");
  if (!(arguments.cells.lowest < arguments.cells.highest))
    throw Error(ErrorCode::kUsage,
                fmt::format("--lowest {} --highest {}: nothing is between them; what counts as an "
                            "obstacle is above the lowest and below the highest",
                            arguments.cells.lowest, arguments.cells.highest));
  require_writable_names(arguments);
  arguments.volume.max_depth = arguments.max_depth;
  const StopSignal signal;
  const SavedMap map = load_map(arguments.map);
  if (map.views.empty())
    throw Error(ErrorCode::kMap,
                fmt::format("{}: this map is empty, there is nothing to write", arguments.map));
  if (arguments.segment) (void)chosen_segment(arguments, map);  // refuses one that is not there
  if (!arguments.trajectory.empty())
    export_trajectory(arguments.trajectory, map, arguments.segment);
  if (arguments.points.empty() && arguments.mesh.empty() && arguments.grid.empty()) return;
  const int segment = chosen_segment(arguments, map);
  if (!arguments.points.empty()) {
    const std::vector<ColoredPoint> points = colored_points(map, segment);
    write_ply(arguments.points, points);
    print("{}: {} points\n", arguments.points, points.size());
  }
  const std::vector<DepthView> views = depth_views(map, segment);
  if (!arguments.mesh.empty()) export_mesh(arguments, views);
  if (!arguments.grid.empty()) export_grid(arguments, views);
}

}  // namespace

void add_map_export(CLI::App& verb) {
  constexpr int kMostThreads = 256;
  constexpr double kFarthest = 1e4;  // [m]
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = verb.add_subcommand("export", "Write points, mesh, grid or trajectory");
  command->add_option("MAP", arguments->map, "File")->required();
  command->add_option("--points", arguments->points, "Points that are tracked, with colour, as PLY")
      ->type_name("FILE.ply");
  command->add_option("--mesh", arguments->mesh, "Surface of triangles with colour, as PLY")
      ->type_name("FILE.ply");
  command
      ->add_option("--grid", arguments->grid,
                   "Occupancy grid for robots, as PGM with a YAML file beside it")
      ->type_name("FILE.pgm");
  command->add_option("--trajectory", arguments->trajectory, "Poses of the keyframes, TUM format")
      ->type_name("FILE.tum");
  command->add_option("--segment", arguments->segment, "Part of the map, default: the largest")
      ->type_name("N");
  command->add_option("--max-depth", arguments->max_depth, "Farther depth is left out [m]")
      ->type_name("METRES")
      ->check(number_between(0.1, 100))
      ->capture_default_str();
  command->add_option("--voxel", arguments->volume.voxel, "Size of the mesh's voxels [m]")
      ->type_name("METRES")
      ->check(number_between(0.001, 1))
      ->capture_default_str();
  command->add_option("--cell", arguments->cells.resolution, "Size of the grid's cells [m]")
      ->type_name("METRES")
      ->check(number_between(0.005, 10))
      ->capture_default_str();
  command
      ->add_option(
          "--up", arguments->up,
          "Direction against gravity in the map's frame, default: as floor and tables tell")
      ->type_name("X Y Z")
      ->expected(3);
  command->add_option("--floor", arguments->floor, "Height of the floor along it, default: as seen")
      ->type_name("METRES")
      ->check(number_between(-kFarthest, kFarthest));
  command
      ->add_option("--lowest", arguments->cells.lowest,
                   "What is lower above the floor is no obstacle [m]")
      ->type_name("METRES")
      ->check(number_between(0.001, kFarthest))
      ->capture_default_str();
  command
      ->add_option("--highest", arguments->cells.highest,
                   "What is higher above the floor is no obstacle [m]")
      ->type_name("METRES")
      ->check(number_between(0.001, kFarthest))
      ->capture_default_str();
  command->add_flag("--force", arguments->force, "Replace files that are there");
  command->add_option("--threads", arguments->threads, "Results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  command->callback([arguments] { export_map(*arguments); });
}

}  // namespace edvo::app
