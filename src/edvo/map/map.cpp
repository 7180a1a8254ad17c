// SPDX-License-Identifier: MIT
#include "edvo/map/map.hpp"

namespace edvo {

KeyframeId Map::add(const Stamp& stamp, int segment, const SE3& world_from_camera) {
  const auto id = static_cast<KeyframeId>(keyframes_.size());
  keyframes_.push_back(
      {.id = id, .stamp = stamp, .segment = segment, .world_from_camera = world_from_camera});
  ++version_;
  return id;
}

void Map::set_pose(KeyframeId id, const SE3& world_from_camera) {
  keyframes_.at(static_cast<std::size_t>(id)).world_from_camera = world_from_camera;
  ++version_;
}

void Map::set_segment(KeyframeId id, int segment) {
  keyframes_.at(static_cast<std::size_t>(id)).segment = segment;
  ++version_;
}

const MapKeyframe& Map::operator[](KeyframeId id) const {
  return keyframes_.at(static_cast<std::size_t>(id));
}

}  // namespace edvo
