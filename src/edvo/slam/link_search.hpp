// SPDX-License-Identifier: MIT
// Looks for keyframes of the same place among all that are kept.
#pragma once

#include "edvo/map/map.hpp"
#include "edvo/slam/place.hpp"
#include "edvo/slam/verify_link.hpp"

#include <span>
#include <vector>

namespace edvo {

struct LoopOptions {
  int recent = 12;                   // keyframes
  int place_candidates = 6;          // per keyframe
  double min_similarity = 0.15;      // [0..1]
  int verified = 2;                  // per keyframe
  int probes = 24;                   // links
  int most_verified = 240;           // links
  double known_translation = 0.015;  // [m], and known_share of the link's own
  double known_rotation = 0.015;     // [rad], and known_share of the link's own
  double known_share = 0.05;         // [1]
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
  visit("probes", self.probes, Range{0, 1e6},
        "links that are aligned at first: if the map tells all of them, no more are");
  visit("most_verified", self.most_verified, Range{0, 1e6}, "links that are aligned at most");
  visit("known_translation", self.known_translation, Range{0, 10},
        "difference from the map's motion up to which a candidate tells nothing new [m]");
  visit("known_rotation", self.known_rotation, Range{0, 3.2}, "the same of the rotation [rad]");
  visit("known_share", self.known_share, Range{0, 1}, "added to both: share of the motion itself");
}

struct SearchOptions {
  AlignOptions tracking;
  LinkOptions links;
  LoopOptions loops;
  int threads = 2;  // the result is the same for any number
};

// What became of each candidate, keyframe by keyframe. Maps: of all keyframes, by id.
class LinkSearch {
 public:
  // places, in the order of their keyframes; kept by reference.
  LinkSearch(const std::vector<Place>& places, const Camera& camera, const SearchOptions& options);

  // By their looks: every so many-th place is looked for in those of them before it, or before
  // `below` if that is not 0 and only those from it on are looked for. At most most_verified links
  // are aligned.
  [[nodiscard]] std::vector<LinkReport> by_looks(std::span<const MapKeyframe> map,
                                                 std::size_t every, int most_verified,
                                                 std::size_t below = 0);

  // By their poses: pairs of two visits whose views overlap most and that were not tried yet.
  [[nodiscard]] std::vector<LinkReport> by_pose(std::span<const MapKeyframe> map,
                                                std::span<const LinkReport> tried,
                                                int most_verified) const;

 private:
  void make_signatures(std::size_t every);
  [[nodiscard]] std::vector<LinkReport> candidates_of(std::span<const MapKeyframe> map,
                                                      const PlaceIndex& index, std::size_t to,
                                                      std::size_t below) const;
  [[nodiscard]] std::vector<PlaceMatch> similar_places(std::span<const MapKeyframe> map,
                                                       const PlaceIndex& index, std::size_t to,
                                                       std::size_t below) const;
  [[nodiscard]] bool differs_little(std::span<const MapKeyframe> map,
                                    const LinkReport& report) const;
  void verify(std::span<const MapKeyframe> map, std::vector<LinkReport>& reports) const;
  [[nodiscard]] const Place& place_of(std::int64_t id) const;

  const std::vector<Place>& places_;
  Camera camera_;
  SearchOptions options_;
  std::vector<PlaceSignature> signatures_;  // empty where not made yet
  std::vector<bool> has_signature_;
};

// The whole search by looks. first_new: places before it are an earlier map, in which those from
// it on are looked for, and nowhere else; 0 = each is looked for in all before it.
[[nodiscard]] std::vector<LinkReport> find_links(const std::vector<Place>& places,
                                                 std::span<const MapKeyframe> map,
                                                 const Camera& camera, const AlignOptions& tracking,
                                                 const LinkOptions& links, const LoopOptions& loops,
                                                 int threads, std::size_t first_new = 0);

}  // namespace edvo
