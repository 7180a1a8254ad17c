// SPDX-License-Identifier: MIT
// Looks for keyframes of the same place among all that are kept.
#pragma once

#include "edvo/map/map.hpp"
#include "edvo/slam/place.hpp"
#include "edvo/slam/verify_link.hpp"

#include <span>

namespace edvo {

struct LoopOptions {
  int recent = 12;                  // keyframes
  int place_candidates = 4;         // per keyframe
  double min_similarity = 0.2;      // [0..1]
  int verified = 2;                 // per keyframe
  double known_translation = 0.03;  // [m], and known_share of the link's own
  double known_rotation = 0.03;     // [rad], and known_share of the link's own
  double known_share = 0.1;         // [1]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, LoopOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("recent", self.recent, Range{1, 1000},
        "the last keyframes of a segment, with which no loop is looked for: tracking has them");
  visit("place_candidates", self.place_candidates, Range{0, 1000},
        "keyframes of similar images whose corners are compared");
  visit("min_similarity", self.min_similarity, Range{0, 1}, "of such keyframes' codes [0..1]");
  visit("verified", self.verified, Range{0, 1000}, "of them, those that are aligned");
  visit("known_translation", self.known_translation, Range{0, 10},
        "difference from the map's motion up to which a candidate tells nothing new [m]");
  visit("known_rotation", self.known_rotation, Range{0, 3.2}, "the same of the rotation [rad]");
  visit("known_share", self.known_share, Range{0, 1}, "added to both: share of the motion itself");
}

// What became of each candidate, keyframe by keyframe. places, in the order of their keyframes;
// map: of all keyframes, by id. first_new: places before it are an earlier map, in which those from
// it on are looked for, and nowhere else; 0 = each is looked for in all before it. The same for any
// number of threads.
[[nodiscard]] std::vector<LinkReport> find_links(const std::vector<Place>& places,
                                                 std::span<const MapKeyframe> map,
                                                 const Camera& camera, const AlignOptions& tracking,
                                                 const LinkOptions& links, const LoopOptions& loops,
                                                 int threads, std::size_t first_new = 0);

}  // namespace edvo
