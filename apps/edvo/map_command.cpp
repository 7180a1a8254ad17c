// SPDX-License-Identifier: MIT
// edvo map: what is done with saved maps; here info, what they hold.
#include "commands.hpp"
#include "edvo/report/summary.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "map_verbs.hpp"
#include "terminal.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <string>

namespace edvo::app {
namespace {

struct InfoArguments {
  std::string map;
  bool json = false;
};

struct SegmentInfo {
  int id = 0;
  std::int64_t keyframes = 0;
  double path = 0;             // [m], along the odometry: runs that were merged do not count twice
  Eigen::AlignedBox3d extent;  // of the camera's way [m]
};

// From keyframe to keyframe, without the jump from the end of one run to the beginning of another.
double path_in(const SavedMap& map, int segment) {
  double length = 0;
  for (const OdometryStep& step : map.steps) {
    const MapKeyframe& from = map.keyframes.at(static_cast<std::size_t>(step.from));
    const MapKeyframe& to = map.keyframes.at(static_cast<std::size_t>(step.to));
    if (from.segment == segment && to.segment == segment)
      length += (to.world_from_camera.translation - from.world_from_camera.translation).norm();
  }
  return length;
}

std::vector<SegmentInfo> describe_segments(const SavedMap& map) {
  std::vector<SegmentInfo> segments;
  for (const int id : segments_of(map)) {
    SegmentInfo info{.id = id, .path = path_in(map, id)};
    for (const MapKeyframe& key : map.keyframes) {
      if (key.segment != id) continue;
      ++info.keyframes;
      info.extent.extend(key.world_from_camera.translation);
    }
    segments.push_back(std::move(info));
  }
  return segments;
}

bool has_colour(const SavedMap& map) {
  return !map.views.empty() && !map.views.front().half_chroma.empty();
}

void print_json(const std::string& path, const SavedMap& map, std::uintmax_t bytes) {
  const MapOrigin& origin = map.origin;
  const Camera& camera = origin.camera;
  nlohmann::ordered_json json = {{"map", path},
                                 {"bytes", bytes},
                                 {"made_by", origin.made_by},
                                 {"method", origin.method},
                                 {"config_hash", config_hash(origin.config)},
                                 {"camera",
                                  {{"fx", camera.fx},
                                   {"fy", camera.fy},
                                   {"cx", camera.cx},
                                   {"cy", camera.cy},
                                   {"width", camera.width},
                                   {"height", camera.height}}},
                                 {"depth_scale", origin.depth_scale},
                                 {"keyframes", map.keyframes.size()},
                                 {"views", map.views.size()},
                                 {"colour", has_colour(map)},
                                 {"links", map.links.size()},
                                 {"segments", nlohmann::ordered_json::array()}};
  for (const SegmentInfo& segment : describe_segments(map)) {
    const Eigen::Vector3d size = segment.extent.sizes();
    json["segments"].push_back({{"id", segment.id},
                                {"keyframes", segment.keyframes},
                                {"path_length_m", segment.path},
                                {"extent_m", {size.x(), size.y(), size.z()}}});
  }
  print_bytes(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n');
}

void print_text(const std::string& path, const SavedMap& map, std::uintmax_t bytes) {
  const MapOrigin& origin = map.origin;
  const Camera& camera = origin.camera;
  print("{}\n", path);
  print("made by    {}, {}, options {}\n", origin.made_by, origin.method,
        config_hash(origin.config));
  print("camera     {} x {}, fx {} fy {} cx {} cy {}\n", camera.width, camera.height, camera.fx,
        camera.fy, camera.cx, camera.cy);
  print("depth      {}\n", origin.depth_scale > 0
                               ? fmt::format("{} units per metre", origin.depth_scale)
                               : "in metres");
  print("keyframes  {}, of {} the images{}; {} links\n", map.keyframes.size(), map.views.size(),
        has_colour(map) ? " with colour" : "", map.links.size());
  for (const SegmentInfo& segment : describe_segments(map)) {
    const Eigen::Vector3d size = segment.extent.sizes();
    print("segment {:<2} {} keyframes, path {:.2f} m, within {:.2f} x {:.2f} x {:.2f} m\n",
          segment.id, segment.keyframes, segment.path, size.x(), size.y(), size.z());
  }
  print("size       {:.1f} MB\n", static_cast<double>(bytes) / 1e6);
}

void show_info(const InfoArguments& arguments) {
  const SavedMap map = load_map(arguments.map);
  const std::uintmax_t bytes = std::filesystem::file_size(arguments.map);
  (arguments.json ? print_json : print_text)(arguments.map, map, bytes);
}

}  // namespace

void add_map_info(CLI::App& verb) {
  const auto arguments = std::make_shared<InfoArguments>();
  CLI::App* info = verb.add_subcommand("info", "What a map holds; reads and checks all of it");
  info->add_option("MAP", arguments->map, "File")->required();
  info->add_flag("--json", arguments->json, "Print one JSON object");
  info->callback([arguments] { show_info(*arguments); });
}

void add_map_command(CLI::App& program) {
  CLI::App* verb =
      program.add_subcommand("map", "Maps of edvo run --save-map: info, export, merge");
  verb->require_subcommand(1);
  add_map_info(*verb);
  add_map_export(*verb);
  add_map_merge(*verb);
}

}  // namespace edvo::app
