// SPDX-License-Identifier: MIT
#include "edvo/saved_map/slam_in_map.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace edvo {

SlamInMap::SlamInMap(const DistortedCamera& camera, const Config& config, const SlamConfig& slam,
                     std::unique_ptr<EdgeDetector> detector, MapOrigin origin,
                     std::optional<SavedMap> map, bool extend)
    : slam_(camera, config, slam, std::move(detector)),
      config_(config),
      options_(slam),
      origin_(std::move(origin)),
      earlier_(std::move(map)),
      extend_(extend) {
  if (earlier_) require_same_camera(*earlier_, "the map", camera.pinhole, "this sequence");
}

void SlamInMap::finish(int threads) {
  slam_.finish(threads);
  if (!earlier_) return;
  MergedMaps merged = merge_maps(*earlier_, make_saved_map(slam_, origin_),
                                 {.tracking = config_.tracking,
                                  .loops = options_.loops,
                                  .links = options_.links,
                                  .window = config_.window,
                                  .hold_first = !extend_,
                                  .threads = threads});
  localization_ = {.segments = adopt(merged), .links = std::move(merged.links)};
  for (LinkReport& link : localization_->links) link.to -= merged.first_of_second;
  if (!extend_ || merged.joined.empty()) return;
  extended_ = std::move(merged.map);
  extended_->origin.made_by = origin_.made_by;
}

// The run keeps its own numbers of segments: of those that are now one, the lowest. Returns those
// that are in the map.
std::vector<int> SlamInMap::adopt(const MergedMaps& merged) {
  std::vector<MapKeyframe> keyframes = slam_.map().keyframes();
  std::map<int, int> segment_of;  // merged -> of the run
  for (MapKeyframe& key : keyframes) {
    const MapKeyframe& now =
        merged.map.keyframes[static_cast<std::size_t>(key.id + merged.first_of_second)];
    const int own = segment_of.try_emplace(now.segment, key.segment).first->second;
    segment_of[now.segment] = std::min(own, key.segment);
  }
  std::set<int> found;
  for (MapKeyframe& key : keyframes) {
    const MapKeyframe& now =
        merged.map.keyframes[static_cast<std::size_t>(key.id + merged.first_of_second)];
    const bool is_found =
        std::binary_search(merged.joined.begin(), merged.joined.end(), key.segment);
    key.world_from_camera = now.world_from_camera;
    key.segment = segment_of.at(now.segment);
    if (is_found) found.insert(key.segment);
  }
  slam_.correct(keyframes);
  return {found.begin(), found.end()};
}

SavedMap SlamInMap::saved_map() const {
  return extended_ ? *extended_ : make_saved_map(slam_, origin_);
}

}  // namespace edvo
