// SPDX-License-Identifier: MIT
#include "run_map.hpp"

#include "edvo/io/output_file.hpp"
#include "edvo/report/machine.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/slam/slam.hpp"
#include "output_name.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace edvo::app {
namespace {

void require_possible(const RunFlags& flags, const Config& config) {
  if (flags.update_map && flags.map.empty())
    throw Error(ErrorCode::kUsage, "--update-map: which map? Give it with --map");
  if (flags.update_map && !flags.save_map.empty())
    throw Error(ErrorCode::kUsage,
                "--update-map writes the map of --map; leave it or --save-map out");
  const std::string option = flags.save_map.empty() ? "--map" : "--save-map";
  if (flags.map.empty() && flags.save_map.empty()) return;
  if (flags.no_loops)
    throw Error(ErrorCode::kUsage, option + ": maps are found by places, leave --no-loops out");
  if (!has_back_end(config))
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: method {} keeps no keyframes; choose --method canny+corner or "
                            "cnn+corner",
                            option, method_name(flags)));
}

std::string depth_text(double scale) {
  return scale > 0 ? fmt::format("{} depth units per metre", scale) : "depth in metres";
}

// An earlier map that this sequence may be in.
SavedMap load_fitting(const std::string& path, const RunDescription& run, bool extends,
                      const std::function<void(const std::string&)>& warn) {
  SavedMap map = load_map(path);
  if (map.views.empty())
    throw Error(ErrorCode::kMap,
                fmt::format("{}: this map is empty, nothing can be found in it", path));
  require_same_camera(map, path, run.camera.pinhole, run.sequence);
  if (map.origin.depth_scale != run.depth_scale) {
    const std::string text =
        fmt::format("{}: the map was made with {}, this sequence has {}", path,
                    depth_text(map.origin.depth_scale), depth_text(run.depth_scale));
    if (extends)
      throw Error(ErrorCode::kMap, text + "; a map is extended only with the same (--depth-scale)");
    warn(text + "; if both are of one camera, one is wrong");
  }
  if (config_hash(map.origin.config) != config_hash(run.config))
    warn(fmt::format("{}: the map was made with other options ({}, {}) than this run ({}, {})",
                     path, map.origin.method, config_hash(map.origin.config), run.method,
                     config_hash(run.config)));
  return map;
}

bool is_localized(const Localization& localization, const StampedPose& pose) {
  return std::binary_search(localization.segments.begin(), localization.segments.end(),
                            pose.segment);
}

// What was found, frame by frame and candidate by candidate.
void write_localization(const Localization& localization, const Trajectory& trajectory,
                        const std::filesystem::path& folder) {
  std::string frames, links;
  for (const StampedPose& pose : trajectory)
    frames += fmt::format("{{\"stamp\": \"{}\", \"segment\": {}, \"localized\": {}}}\n",
                          to_string(pose.stamp), pose.segment, is_localized(localization, pose));
  for (const LinkReport& link : localization.links) links += to_json_line(link) + '\n';
  write_whole(folder / "localization.jsonl", frames);
  write_whole(folder / "map_links.jsonl", links);
}

}  // namespace

RunMaps::RunMaps(const RunFlags& flags, const Config& config, const RunDescription& run,
                 const std::function<void(const std::string&)>& warn)
    : map_(flags.map),
      target_(flags.update_map ? flags.map : flags.save_map),
      extends_(flags.update_map),
      origin_{.camera = run.camera.pinhole,
              .depth_scale = run.depth_scale,
              .method = run.method,
              .config = run.config,
              .made_by = "edvo " + this_machine().edvo} {
  require_possible(flags, config);
  if (!flags.save_map.empty()) require_new_map("--save-map", flags.save_map, flags.force);
  require_writable("--map", extends_ ? flags.map : "");
  if (!target_.empty()) lock_ = std::make_unique<MapLock>(target_);
  if (!map_.empty()) earlier_ = load_fitting(map_, run, extends_, warn);
}

std::optional<Error> RunMaps::finish(const SlamInMap& slam, const Trajectory& trajectory,
                                     const std::optional<std::filesystem::path>& folder) const {
  const std::optional<Localization>& localization = slam.localization();
  if (localization && folder) write_localization(*localization, trajectory, *folder);
  const bool is_found = !localization || !localization->segments.empty();
  // A run that tracked nothing replaces no map.
  if (writes() && (is_found || !extends_) && !slam.map().keyframes().empty())
    save_map(target_, slam.saved_map());
  if (is_found) return std::nullopt;
  return Error(ErrorCode::kMap,
               fmt::format("{}: no part of this run was found in the map{}{}", map_,
                           extends_ ? ", which stays as it was" : "",
                           folder ? fmt::format("; {} says what was tried",
                                                (*folder / "map_links.jsonl").string())
                                  : ""));
}

std::int64_t localized_frames(const Localization& localization, const Trajectory& trajectory) {
  return std::count_if(trajectory.begin(), trajectory.end(),
                       [&](const StampedPose& pose) { return is_localized(localization, pose); });
}

}  // namespace edvo::app
