// SPDX-License-Identifier: MIT
#include "edvo/window/keyframe_unknowns.hpp"

namespace edvo {

Estimates estimates_of(const std::vector<WindowKeyframe>& window) {
  Estimates all;
  for (const WindowKeyframe& key : window) {
    all.keyframes.push_back({key.world_from_key, key.gain, key.bias});
    for (const WindowPoint& point : key.points) all.inverse_depths.push_back(point.inverse_depth);
  }
  return all;
}

void restore(const Estimates& all, std::vector<WindowKeyframe>& window) {
  auto depth = all.inverse_depths.begin();
  for (std::size_t k = 0; k < window.size(); ++k) {
    WindowKeyframe& key = window[k];
    key.world_from_key = all.keyframes[k].world_from_key;
    key.gain = all.keyframes[k].gain;
    key.bias = all.keyframes[k].bias;
    for (WindowPoint& point : key.points) point.inverse_depth = *depth++;
  }
}

}  // namespace edvo
