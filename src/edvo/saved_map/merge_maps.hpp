// SPDX-License-Identifier: MIT
// Joins two maps by the places that both show.
#pragma once

#include "edvo/saved_map/saved_map.hpp"

#include <vector>

namespace edvo {

struct MergeOptions {
  AlignOptions tracking;  // of the methods that made the maps
  LoopOptions loops;
  LinkOptions links;
  WindowOptions window;     // of the last refinement
  bool hold_first = false;  // the first map's poses stay as they are
  int threads = 2;          // the result is the same for any number
};

struct MergedMaps {
  // The first map's keyframes, then the second's, whose ids and segments count on.
  SavedMap map;
  KeyframeId first_of_second = 0;
  std::vector<LinkReport> links;  // each candidate between the two, by the ids in map
  std::vector<int> joined;  // segments of the second, as numbered there, now in one of the first
};

// Keyframes of the second are looked for in the first and verified, as Slam does between segments;
// where two links agree, the second's segment is moved into the first's frame, and all poses are
// brought to where steps and links agree best, and refined jointly on their pixels (unless the
// first map is held). Nothing is joined where nothing is found. Throws Error(kMap) if the cameras
// differ.
[[nodiscard]] MergedMaps merge_maps(const SavedMap& first, const SavedMap& second,
                                    const MergeOptions& options);

// Throws Error(kMap) that names both cameras.
void require_same_camera(const SavedMap& map, const std::string& name, const Camera& camera,
                         const std::string& whose);

}  // namespace edvo
