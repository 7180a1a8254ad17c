// SPDX-License-Identifier: MIT
// SLAM that finds itself in an earlier map and can extend it. The same door as Slam.
#pragma once

#include "edvo/saved_map/merge_maps.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace edvo {

// Where a run was in an earlier map.
struct Localization {
  std::vector<int> segments;      // of the run's trajectory, those found in the map, ascending
  std::vector<LinkReport> links;  // from: keyframe of the map, to: keyframe of the run
};

// While images come it is Slam. finish() also looks for its keyframes in the map: segments that are
// found are moved into the map's frame. Other segments keep a frame of their own.
class SlamInMap {
 public:
  // map: none = there is no earlier one. Throws as Slam does, and Error(kMap) if the map's camera
  // is another one.
  SlamInMap(const DistortedCamera& camera, const Config& config, const SlamConfig& slam,
            std::unique_ptr<EdgeDetector> detector, MapOrigin origin, std::optional<SavedMap> map,
            bool extend);

  FrameResult process(const RgbdImage& image) { return slam_.process(image); }
  [[nodiscard]] PreparedImage prepare(const RgbdImage& image) const { return slam_.prepare(image); }
  FrameResult process(const PreparedImage& image) { return slam_.process(image); }

  // Call it once after the last image. The result is the same for any number of threads.
  void finish(int threads = 2);

  [[nodiscard]] Trajectory trajectory() const { return slam_.trajectory(); }
  [[nodiscard]] Trajectory keyframe_trajectory() const { return slam_.keyframe_trajectory(); }
  [[nodiscard]] const Map& map() const { return slam_.map(); }
  [[nodiscard]] KeyframePtr newest_keyframe() const { return slam_.newest_keyframe(); }
  [[nodiscard]] MapFrame map_frame(int segment) const { return slam_.map_frame(segment); }
  [[nodiscard]] const std::vector<LinkReport>& links() const { return slam_.links(); }

  // After finish(); none if there is no earlier map.
  [[nodiscard]] const std::optional<Localization>& localization() const { return localization_; }

  // After finish(), the map to be saved: of this run, or the earlier one with it.
  [[nodiscard]] SavedMap saved_map() const;

 private:
  std::vector<int> adopt(const MergedMaps& merged);

  Slam slam_;
  Config config_;
  SlamConfig options_;
  MapOrigin origin_;
  std::optional<SavedMap> earlier_;
  bool extend_;
  std::optional<Localization> localization_;
  std::optional<SavedMap> extended_;
};

}  // namespace edvo
