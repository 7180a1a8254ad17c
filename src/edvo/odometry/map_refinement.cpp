// SPDX-License-Identifier: MIT
// What Odometry does with the keyframes of all segments, between settle() and the end of finish().
#include "edvo/odometry/odometry_state.hpp"

#include "edvo/window/joint_refinement.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace edvo {
namespace {

// Keyframes for each that still has its images, at most, for those to be refined together. Where
// more lie between two, they share too little view: of a rendered walk of 100 m the error is 4.4
// instead of 6.5 mm at 2.3, 5.4 and 6.4 at 3.5, but 6.9 and 6.3 at 4.7, 10.7 and 6.5 at 7.
constexpr std::size_t kMostThinned = 4;

}  // namespace

// At most as many keyframes as a window has candidates are kept, first all and then every second.
void Odometry::State::archive_segment(Segment&& old) {
  std::vector<WindowKeyframe>& keyframes = old.window.keyframes();
  archive.insert(archive.end(), std::make_move_iterator(keyframes.begin()),
                 std::make_move_iterator(keyframes.end()));
  if (archive.size() <= static_cast<std::size_t>(config.window.candidate_keyframes)) return;
  std::vector<WindowKeyframe> fewer;
  for (std::size_t k = 0; k < archive.size(); k += 2) fewer.push_back(std::move(archive[k]));
  archive = std::move(fewer);
}

// By id.
std::vector<WindowKeyframe*> Odometry::State::all_keyframes() {
  std::vector<WindowKeyframe*> all;
  const auto add = [&all](std::vector<WindowKeyframe>& keyframes) {
    for (WindowKeyframe& key : keyframes) all.push_back(&key);
  };
  add(archive);
  add(segment.window.keyframes());
  if (left_segment) add(left_segment->window.keyframes());
  std::sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return a->id < b->id; });
  return all;
}

void Odometry::State::correct(std::span<const MapKeyframe> keyframes) {
  for (const MapKeyframe& key : keyframes) {
    map.set_pose(key.id, key.world_from_camera);
    map.set_segment(key.id, key.segment);
  }
  for (WindowKeyframe* const key : all_keyframes())
    key->world_from_key = map[key->id].world_from_camera;
  if (segment.keyframe >= 0) segment.id = map[segment.keyframe].segment;
  if (left_segment) left_segment->id = map[left_segment->keyframe].segment;
}

// Keyframes whose images were dropped follow the one before them.
void Odometry::State::refine_all(int threads) {
  if (config.window.keyframes == 0 || config.window.final_iterations == 0) return;
  if (all_keyframes().size() * kMostThinned < map.keyframes().size()) return;
  const JointOptions joint{.iterations = config.window.final_iterations, .threads = threads};
  std::map<int, std::vector<WindowKeyframe*>> segments_of;
  for (WindowKeyframe* const key : all_keyframes()) {
    key->shutter.readout_seconds = readout.seconds();
    segments_of[map[key->id].segment].push_back(key);
  }
  std::map<KeyframeId, SE3> refined;
  for (const auto& [id, members] : segments_of) {
    std::vector<WindowKeyframe> together;
    for (WindowKeyframe* const key : members) together.push_back(std::move(*key));
    refine_jointly(together, keyframes_in_view(together, undistortion.camera, joint.neighbours),
                   undistortion.camera, config.window, joint);
    for (std::size_t k = 0; k < members.size(); ++k) {
      refined[together[k].id] = together[k].world_from_key;
      *members[k] = std::move(together[k]);
    }
  }
  std::map<int, SE3> corrections;  // of each segment's last one refined: world from old world
  for (const MapKeyframe& key : std::vector(map.keyframes())) {
    const auto known = refined.find(key.id);
    SE3& correction = corrections[key.segment];
    if (known != refined.end()) correction = known->second * inverse(key.world_from_camera);
    map.set_pose(key.id,
                 known != refined.end() ? known->second : correction * key.world_from_camera);
  }
}

}  // namespace edvo
