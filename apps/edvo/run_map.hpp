// SPDX-License-Identifier: MIT
// The maps of a run: the one in which it finds itself, and the one that it leaves.
#pragma once

#include "edvo/odometry/config.hpp"
#include "edvo/report/summary.hpp"
#include "edvo/saved_map/map_lock.hpp"
#include "edvo/saved_map/slam_in_map.hpp"
#include "run_flags.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace edvo::app {

// Locks the file that will be written and reads the map that is there, before a frame is tracked.
class RunMaps {
 public:
  // warn: told what does not quite fit. Throws Error(kUsage) if the flags ask for a map that this
  // run cannot make, Error(kMap) if the map does not fit the sequence or is in use, Error(kOutput)
  // if --save-map names a file that is there.
  RunMaps(const RunFlags& flags, const Config& config, const RunDescription& run,
          const std::function<void(const std::string&)>& warn);

  [[nodiscard]] bool writes() const { return lock_ != nullptr; }

  // What a map made by this run says of itself.
  [[nodiscard]] const MapOrigin& origin() const { return origin_; }

  // The earlier map; once.
  [[nodiscard]] std::optional<SavedMap> take_earlier() { return std::move(earlier_); }

  // After the run: writes the map, and localization.jsonl and map_links.jsonl in the run's folder,
  // if it has one. Returns why the run is a failure: it was not found in the map.
  [[nodiscard]] std::optional<Error> finish(
      const SlamInMap& slam, const Trajectory& trajectory,
      const std::optional<std::filesystem::path>& folder) const;

 private:
  std::string map_, target_;  // files, empty = none
  bool extends_;
  MapOrigin origin_;
  std::unique_ptr<MapLock> lock_;
  std::optional<SavedMap> earlier_;
};

// Frames of the final trajectory that are in the map's frame.
[[nodiscard]] std::int64_t localized_frames(const Localization& localization,
                                            const Trajectory& trajectory);

}  // namespace edvo::app
