// SPDX-License-Identifier: MIT
#include "edvo/slam/link_search.hpp"

#include "edvo/core/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

constexpr std::int64_t kSameVisit = 4;  // keyframes this close in time tell the same

class LinkSearch {
 public:
  LinkSearch(const std::vector<Place>& places, std::span<const MapKeyframe> map,
             const Camera& camera, const AlignOptions& tracking, const LinkOptions& links,
             const LoopOptions& loops, int threads, std::size_t first_new)
      : places_(places),
        map_(map),
        camera_(camera),
        tracking_(tracking),
        links_(links),
        loops_(loops),
        first_new_(first_new),
        signatures_(places.size()) {
    for_each_index(static_cast<int>(places.size()), threads, [&](int i) {
      signatures_[static_cast<std::size_t>(i)] =
          make_signature(places_[static_cast<std::size_t>(i)], camera_);
    });
    for (std::size_t i = 0; i < places.size(); ++i)
      index_.add(static_cast<std::int64_t>(i), signatures_[i].code);
  }

  [[nodiscard]] std::vector<LinkReport> links_of(std::size_t to) const {
    std::vector<LinkReport> reports;
    for (const PlaceMatch& match : candidates(to)) {
      const auto from = static_cast<std::size_t>(match.id);
      LinkReport report{.from = places_[from].id, .to = places_[to].id};
      report.similarity = match.similarity;
      const std::optional<SE3> motion =
          motion_of_corners(signatures_[from].features, signatures_[to].features, links_, report);
      if (motion) {
        report.from_pose_to = *motion;
        report.status = is_known(report) ? LinkStatus::kKnown : LinkStatus::kAccepted;
      }
      reports.push_back(report);
    }
    verify_best(to, reports);
    return reports;
  }

 private:
  [[nodiscard]] const MapKeyframe& key(std::int64_t id) const {
    return map_[static_cast<std::size_t>(id)];
  }

  // The most similar places of other segments and of earlier visits, one of each visit.
  [[nodiscard]] std::vector<PlaceMatch> candidates(std::size_t to) const {
    std::vector<PlaceMatch> chosen;
    const auto most = static_cast<std::size_t>(loops_.place_candidates);
    const std::int64_t id = places_[to].id;
    for (const PlaceMatch& match : index_.search(
             signatures_[to].code, static_cast<std::int64_t>(first_new_ > 0 ? first_new_ : to),
             8 * most + static_cast<std::size_t>(loops_.recent))) {
      if (chosen.size() == most || match.similarity < loops_.min_similarity) break;
      const std::int64_t other = places_[static_cast<std::size_t>(match.id)].id;
      if (key(other).segment == key(id).segment && id - other <= loops_.recent) continue;
      const bool joined = key(other).segment != key(id).segment;
      const auto is_near = [&](const PlaceMatch& c) {
        return !joined && std::abs(places_[static_cast<std::size_t>(c.id)].id - other) < kSameVisit;
      };
      if (std::none_of(chosen.begin(), chosen.end(), is_near)) chosen.push_back(match);
    }
    return chosen;
  }

  [[nodiscard]] bool is_known(const LinkReport& report) const {
    const MapKeyframe &from = key(report.from), &to = key(report.to);
    if (from.segment != to.segment) return false;
    const SE3 mapped = inverse(from.world_from_camera) * to.world_from_camera;
    const SE3 error = inverse(mapped) * report.from_pose_to;
    return error.translation.norm() <
               loops_.known_translation + loops_.known_share * mapped.translation.norm() &&
           rotation_angle(error) <
               loops_.known_rotation + loops_.known_share * rotation_angle(mapped);
  }

  // Those of most inliers are aligned; the others stay unverified.
  void verify_best(std::size_t to, std::vector<LinkReport>& reports) const {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < reports.size(); ++k)
      if (reports[k].status == LinkStatus::kAccepted) order.push_back(k);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return reports[a].inliers > reports[b].inliers;
    });
    std::optional<KeyframeView> view;
    for (std::size_t k = 0; k < order.size(); ++k) {
      LinkReport& report = reports[order[k]];
      if (k >= static_cast<std::size_t>(loops_.verified)) {
        report.status = LinkStatus::kNotTried;
        continue;
      }
      if (!view) view = make_view(keyframe_of(places_[to]), camera_, tracking_);
      const auto from =
          std::lower_bound(places_.begin(), places_.end(), report.from,
                           [](const Place& place, std::int64_t id) { return place.id < id; });
      const double similarity = report.similarity;
      report = verify_link(make_view(keyframe_of(*from), camera_, tracking_), *view,
                           report.from_pose_to, tracking_, links_);
      report.similarity = similarity;
      if (report.status == LinkStatus::kAccepted && is_known(report))
        report.status = LinkStatus::kKnown;
    }
  }

  const std::vector<Place>& places_;
  std::span<const MapKeyframe> map_;
  Camera camera_;
  AlignOptions tracking_;
  LinkOptions links_;
  LoopOptions loops_;
  std::size_t first_new_;
  std::vector<PlaceSignature> signatures_;
  PlaceIndex index_;  // by position in places_
};

}  // namespace

std::vector<LinkReport> find_links(const std::vector<Place>& places,
                                   std::span<const MapKeyframe> map, const Camera& camera,
                                   const AlignOptions& tracking, const LinkOptions& links,
                                   const LoopOptions& loops, int threads, std::size_t first_new) {
  const LinkSearch search(places, map, camera, tracking, links, loops, threads, first_new);
  std::vector<std::vector<LinkReport>> found(places.size());
  for_each_index(static_cast<int>(places.size()), threads, [&](int i) {
    const auto place = static_cast<std::size_t>(i);
    if (place >= first_new) found[place] = search.links_of(place);
  });
  std::vector<LinkReport> all;
  for (const std::vector<LinkReport>& reports : found)
    all.insert(all.end(), reports.begin(), reports.end());
  return all;
}

}  // namespace edvo
