// SPDX-License-Identifier: MIT
#include "edvo/slam/slam.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace edvo {
namespace {

// The one, not the first nor the last, without which the least gap is left.
void drop_one(std::vector<Place>& places, const Map& map) {
  std::size_t best = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    const MapKeyframe &before = map[places[i - 1].id], &after = map[places[i + 1].id];
    if (before.segment != after.segment) continue;
    const SE3 gap = inverse(before.world_from_camera) * after.world_from_camera;
    const double size = gap.translation.norm() + rotation_angle(gap);
    if (size >= least) continue;
    least = size;
    best = i;
  }
  places.erase(places.begin() + static_cast<std::ptrdiff_t>(best));
}

}  // namespace

Slam::Slam(const DistortedCamera& camera, const Config& config, const SlamConfig& slam,
           std::unique_ptr<EdgeDetector> detector)
    : odometry_(camera, config, std::move(detector)),
      camera_(camera.pinhole),
      config_(config),
      slam_(slam) {}

FrameResult Slam::process(const PreparedImage& image) {
  FrameResult result = odometry_.process(image);
  if (result.new_keyframe) add_place(result);
  return result;
}

void Slam::add_place(const FrameResult& result) {
  if (result.keyframe != *result.new_keyframe)
    steps_.push_back(
        {.from = result.keyframe, .to = *result.new_keyframe, .information = result.information});
  places_.push_back(make_place(*odometry_.newest_keyframe(), slam_.keep_colour));
  if (places_.size() > static_cast<std::size_t>(config_.window.candidate_keyframes))
    drop_one(places_, odometry_.map());
}

// To join segments each of which may be short, all places are needed; to find drift in a single
// one, fewer are.
std::vector<Place> Slam::searched_places() const {
  constexpr std::size_t kEvery = 3;
  const std::vector<MapKeyframe>& keyframes = odometry_.map().keyframes();
  const bool single = std::all_of(keyframes.begin(), keyframes.end(), [&](const MapKeyframe& key) {
    return key.segment == keyframes.front().segment;
  });
  if (!single) return places_;
  std::vector<Place> fewer;
  for (std::size_t i = 0; i < places_.size(); i += kEvery) fewer.push_back(places_[i]);
  return fewer;
}

void Slam::finish(int threads) {
  odometry_.settle();
  std::vector<MapKeyframe> keyframes = odometry_.map().keyframes();
  links_ = find_links(searched_places(), keyframes, camera_, config_.tracking, slam_.links,
                      slam_.loops, threads);
  join_segments(keyframes, links_);
  close_loops(keyframes, steps_, links_);
  odometry_.correct(keyframes);
  odometry_.finish(threads);
}

}  // namespace edvo
