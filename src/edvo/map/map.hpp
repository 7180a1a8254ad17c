// SPDX-License-Identifier: MIT
// The poses of all keyframes. Frames hang on a keyframe, so that a correction here moves them too.
#pragma once

#include "edvo/core/se3.hpp"
#include "edvo/core/stamp.hpp"

#include <cstdint>
#include <vector>

namespace edvo {

using KeyframeId = std::int64_t;  // counts up from 0 over all segments

struct MapKeyframe {
  KeyframeId id = 0;
  Stamp stamp;
  int segment = 0;  // between two segments no motion is known
  SE3 world_from_camera;
};

// Not synchronized: one thread at a time.
class Map {
 public:
  KeyframeId add(const Stamp& stamp, int segment, const SE3& world_from_camera);

  // id: one that add() gave.
  void set_pose(KeyframeId id, const SE3& world_from_camera);
  void set_segment(KeyframeId id, int segment);
  [[nodiscard]] const MapKeyframe& operator[](KeyframeId id) const;

  [[nodiscard]] const std::vector<MapKeyframe>& keyframes() const { return keyframes_; }

  // Grows with every change: who has seen this version needs no update.
  [[nodiscard]] std::uint64_t version() const { return version_; }

 private:
  std::vector<MapKeyframe> keyframes_;  // by id
  std::uint64_t version_ = 0;
};

}  // namespace edvo
