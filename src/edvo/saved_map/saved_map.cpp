// SPDX-License-Identifier: MIT
#include "edvo/saved_map/saved_map.hpp"

#include <algorithm>
#include <utility>

namespace edvo {

SavedMap make_saved_map(const Slam& slam, MapOrigin origin) {
  SavedMap map{.origin = std::move(origin),
               .keyframes = slam.map().keyframes(),
               .views = slam.places(),
               .steps = slam.steps(),
               .links = {}};
  for (const LinkReport& link : slam.links())
    if (link.status == LinkStatus::kAccepted)
      map.links.push_back({.from = link.from,
                           .to = link.to,
                           .from_pose_to = link.from_pose_to,
                           .information = link.information});
  return map;
}

std::vector<int> segments_of(const SavedMap& map) {
  std::vector<int> segments;
  for (const MapKeyframe& key : map.keyframes) segments.push_back(key.segment);
  std::sort(segments.begin(), segments.end());
  segments.erase(std::unique(segments.begin(), segments.end()), segments.end());
  return segments;
}

}  // namespace edvo
