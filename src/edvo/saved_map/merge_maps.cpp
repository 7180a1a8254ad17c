// SPDX-License-Identifier: MIT
#include "edvo/saved_map/merge_maps.hpp"

#include "edvo/core/error.hpp"
#include "edvo/saved_map/refine_map.hpp"
#include "edvo/slam/pose_graph.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

namespace edvo {
namespace {

int segment_count(const SavedMap& map) {
  int count = 0;
  for (const MapKeyframe& key : map.keyframes) count = std::max(count, key.segment + 1);
  return count;
}

// Appends a map, whose ids and segments count on from those there.
void append(SavedMap& all, const SavedMap& map) {
  const auto ids = static_cast<KeyframeId>(all.keyframes.size());
  const int segments = segment_count(all);
  for (MapKeyframe key : map.keyframes) {
    key.id += ids;
    key.segment += segments;
    all.keyframes.push_back(key);
  }
  for (Place view : map.views) {
    view.id += ids;
    all.views.push_back(std::move(view));
  }
  const auto append_motions = [ids](auto& motions, const auto& others) {
    for (auto motion : others) {
      motion.from += ids;
      motion.to += ids;
      motions.push_back(motion);
    }
  };
  append_motions(all.steps, map.steps);
  append_motions(all.links, map.links);
}

// The graph of both maps, in which only the new links can be switched off: what holds a map
// together is taken as it is, with its present motion as measured.
class MergeGraph {
 public:
  MergeGraph(const SavedMap& all, KeyframeId first_of_second, bool hold_first)
      : all_(all), held_(hold_first ? first_of_second : 0) {
    for (const MapKeyframe& key : all.keyframes) {
      graph_.world_from_node.push_back(key.world_from_camera);
      anchor_.try_emplace(key.segment, key.id);
    }
    for (const OdometryStep& step : all.steps)
      add_present(step.from, step.to, step_information(step));
    for (const MapLink& link : all.links) add_present(link.from, link.to, link.information);
  }

  // Those that contradict the others become kCycle. False if the poses could not be found.
  bool solve(std::vector<LinkReport>& links) {
    const std::size_t before = graph_.links.size();
    std::vector<LinkReport*> used;
    for (LinkReport& link : links) {
      if (link.status != LinkStatus::kAccepted) continue;
      weaken_link(link);
      add_loop(link);
      used.push_back(&link);
    }
    const GraphSummary summary = select_links(graph_);
    for (std::size_t k = 0; k < used.size(); ++k) {
      const GraphLink& link = graph_.links[before + k];
      used[k]->cycle_chi_square = chi_square(graph_, link);
      if (!link.enabled) used[k]->status = LinkStatus::kCycle;
    }
    return summary.status != GraphStatus::kNotFinite;
  }

  [[nodiscard]] const std::vector<SE3>& poses() const { return graph_.world_from_node; }

 private:
  [[nodiscard]] const MapKeyframe& key(KeyframeId id) const {
    return all_.keyframes[static_cast<std::size_t>(id)];
  }

  void add_present(KeyframeId from, KeyframeId to, const Matrix6d& information) {
    if (from < held_ && to < held_) return;
    graph_.links.push_back(
        {.from = static_cast<int>(from),
         .to = static_cast<int>(to),
         .from_pose_to = inverse(key(from).world_from_camera) * key(to).world_from_camera,
         .information = information});
  }

  // To a held keyframe: as if from the first one of its segment, which stays where it is.
  void add_loop(const LinkReport& link) {
    KeyframeId from = link.from;
    SE3 motion = link.from_pose_to;
    if (from < held_) {
      from = anchor_.at(key(link.from).segment);
      motion = inverse(key(from).world_from_camera) * key(link.from).world_from_camera * motion;
    }
    graph_.links.push_back({.from = static_cast<int>(from),
                            .to = static_cast<int>(link.to),
                            .from_pose_to = motion,
                            .information = link.information,
                            .kind = LinkKind::kLoop});
  }

  const SavedMap& all_;
  KeyframeId held_;                   // keyframes below it stay
  std::map<int, KeyframeId> anchor_;  // the first keyframe of each segment
  PoseGraph graph_;
};

KeyframeId count_of(const SavedMap& map) {
  return static_cast<KeyframeId>(map.keyframes.size());
}

// Which of two maps is searched for the other's keyframes does not depend on the order in which
// they are given.
bool is_older(const SavedMap& a, const SavedMap& b) {
  const auto key_of = [](const SavedMap& map) {
    return std::pair(map.keyframes.empty() ? 0 : map.keyframes.front().stamp.nanoseconds,
                     map.keyframes.size());
  };
  return key_of(a) < key_of(b);
}

// By the ids in the first map with the second behind it.
std::vector<LinkReport> links_between(const SavedMap& first, const SavedMap& second,
                                      const MergeOptions& options) {
  if (first.views.empty() || second.views.empty()) return {};
  const bool swapped = !options.hold_first && is_older(second, first);
  const SavedMap &searched = swapped ? second : first, &looked_for = swapped ? first : second;
  SavedMap both = searched;
  append(both, looked_for);
  std::vector<LinkReport> links =
      find_links(both.views, both.keyframes, first.origin.camera, options.tracking, options.links,
                 options.loops, options.threads, searched.views.size());
  if (!swapped) return links;
  const auto renamed = [&](KeyframeId id) {
    return id < count_of(second) ? id + count_of(first) : id - count_of(second);
  };
  for (LinkReport& link : links) {
    link.from = renamed(link.from);
    link.to = renamed(link.to);
  }
  return links;
}

// What the new links say once they have been judged.
void keep_accepted(const std::vector<LinkReport>& links, SavedMap& map) {
  for (const LinkReport& link : links)
    if (link.status == LinkStatus::kAccepted)
      map.links.push_back({.from = link.from,
                           .to = link.to,
                           .from_pose_to = link.from_pose_to,
                           .information = link.information});
}

std::string to_text(const Camera& c) {
  return fmt::format("{} x {}, fx {:.6g} fy {:.6g} cx {:.6g} cy {:.6g}", c.width, c.height, c.fx,
                     c.fy, c.cx, c.cy);
}

}  // namespace

void require_same_camera(const SavedMap& map, const std::string& name, const Camera& camera,
                         const std::string& whose) {
  constexpr double kSame = 0.5;  // [px]
  const Camera& own = map.origin.camera;
  const auto differ = [](double a, double b) { return !(std::abs(a - b) <= kSame); };
  if (own.width != camera.width || own.height != camera.height || differ(own.fx, camera.fx) ||
      differ(own.fy, camera.fy) || differ(own.cx, camera.cx) || differ(own.cy, camera.cy))
    throw Error(ErrorCode::kMap,
                fmt::format("{}: was made with another camera ({}) than that of {} ({})", name,
                            to_text(own), whose, to_text(camera)));
}

MergedMaps merge_maps(const SavedMap& first, const SavedMap& second, const MergeOptions& options) {
  require_same_camera(first, "the first map", second.origin.camera, "the other");
  MergedMaps merged{.map = first,
                    .first_of_second = static_cast<KeyframeId>(first.keyframes.size())};
  SavedMap& all = merged.map;
  const int first_segments = segment_count(first);
  append(all, second);
  merged.links = links_between(first, second, options);
  join_segments(all.keyframes, merged.links);
  MergeGraph graph(all, merged.first_of_second, options.hold_first);
  if (graph.solve(merged.links))
    for (std::size_t i = 0; i < all.keyframes.size(); ++i)
      all.keyframes[i].world_from_camera = graph.poses()[i];
  keep_accepted(merged.links, all);

  std::set<int> joined;
  for (const MapKeyframe& key : second.keyframes)
    if (all.keyframes[static_cast<std::size_t>(key.id + merged.first_of_second)].segment <
        first_segments)
      joined.insert(key.segment);
  merged.joined.assign(joined.begin(), joined.end());
  if (!options.hold_first && !joined.empty()) refine_map(all, options.window, options.threads);
  return merged;
}

}  // namespace edvo
