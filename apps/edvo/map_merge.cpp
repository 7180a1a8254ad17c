// SPDX-License-Identifier: MIT
// edvo map merge: several maps of one place as one.
#include "map_verbs.hpp"

#include "edvo/core/error.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/report/summary.hpp"
#include "edvo/saved_map/map_file.hpp"
#include "edvo/saved_map/map_lock.hpp"
#include "edvo/saved_map/merge_maps.hpp"
#include "output_name.hpp"
#include "terminal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace edvo::app {
namespace {

struct Arguments {
  std::vector<std::string> maps;
  std::string output;
  bool force = false;
  int threads = 2;
};

SavedMap load_filled(const std::string& file) {
  SavedMap map = load_map(file);
  if (map.views.empty()) throw Error(ErrorCode::kMap, fmt::format("{}: this map is empty", file));
  return map;
}

// The options that the map was made with, so that it is compared as its own frames were.
Config options_of(const SavedMap& map, const std::string& file) {
  try {
    return config_from_toml(map.origin.config, file, preset(Method::kCannyCorner));
  } catch (const Error& error) {
    throw Error(ErrorCode::kMap,
                fmt::format("{}: the options that this map was made with are not those of this "
                            "edvo: {}",
                            file, error.what()));
  }
}

void require_alike(const SavedMap& a, const std::string& file_a, const SavedMap& b,
                   const std::string& file_b) {
  require_same_camera(a, file_a, b.origin.camera, file_b);
  if (a.origin.depth_scale != b.origin.depth_scale)
    throw Error(ErrorCode::kMap,
                fmt::format("{} has {} depth units per metre, {} has {}: maps are merged only with "
                            "the same",
                            file_a, a.origin.depth_scale, file_b, b.origin.depth_scale));
  if (a.origin.config != b.origin.config)
    say("warning: {} was made with other options than {}\n", file_b, file_a);
}

// A map joined to itself would only be twice as large.
void require_different_maps(const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      std::error_code error;
      if (std::filesystem::equivalent(files[i], files[j], error))
        throw Error(ErrorCode::kUsage, fmt::format("{}: is the same file as {}; name each map once",
                                                   files[i], files[j]));
    }
}

// Joins to the first map, in rounds, whatever overlaps with it by then.
void merge(const Arguments& arguments) {
  require_new_map("-o", arguments.output, arguments.force);
  require_different_maps(arguments.maps);
  const MapLock lock(arguments.output);
  std::vector<std::string> files = arguments.maps;
  std::vector<SavedMap> maps;
  for (const std::string& file : files) {
    maps.push_back(load_filled(file));
    require_alike(maps.front(), files.front(), maps.back(), file);
  }
  const Config config = options_of(maps.front(), files.front());
  const MergeOptions options{.tracking = config.tracking,
                             .loops = {},
                             .links = {},
                             .window = config.window,
                             .threads = arguments.threads};
  SavedMap whole = std::move(maps.front());
  maps.erase(maps.begin());
  files.erase(files.begin());
  for (std::size_t i = 0; i < maps.size();) {
    MergedMaps merged = merge_maps(whole, maps[i], options);
    if (merged.joined.empty()) {
      ++i;
      continue;
    }
    const auto links =
        std::count_if(merged.links.begin(), merged.links.end(),
                      [](const LinkReport& link) { return link.status == LinkStatus::kAccepted; });
    print("{}: joined by {} links\n", files[i], links);
    whole = std::move(merged.map);
    maps.erase(maps.begin() + static_cast<std::ptrdiff_t>(i));
    files.erase(files.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;
  }
  if (!maps.empty())
    throw Error(ErrorCode::kMap,
                fmt::format("{}: shows no place that {} shows, or too little of it to be sure; "
                            "nothing is written",
                            fmt::join(files, ", "), arguments.maps.front()));
  save_map(arguments.output, whole);
  print("{}: {} keyframes, {} links\n", arguments.output, whole.keyframes.size(),
        whole.links.size());
}

}  // namespace

void add_map_merge(CLI::App& verb) {
  constexpr int kMostMaps = 100, kMostThreads = 256;
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      verb.add_subcommand("merge", "Join maps of one place, in the frame of the first");
  command->add_option("MAPS", arguments->maps, "Files, two or more")
      ->required()
      ->expected(2, kMostMaps);
  command->add_option("-o,--output", arguments->output, "File to write")
      ->required()
      ->type_name("FILE");
  command->add_flag("--force", arguments->force, "Replace the map that is there");
  command->add_option("--threads", arguments->threads, "Results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  command->callback([arguments] { merge(*arguments); });
}

}  // namespace edvo::app
