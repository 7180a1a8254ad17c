// SPDX-License-Identifier: MIT
#include "edvo/slam/link_search.hpp"

#include "edvo/core/parallel.hpp"
#include "edvo/slam/map_correction.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

namespace edvo {
namespace {

constexpr std::int64_t kSameVisit = 4;  // keyframes this close in time tell the same
constexpr double kNothingNew = 12.59;   // chi-square of 6 degrees of freedom at 0.95
constexpr double kView = 0.5;           // [0..1] of the points that both must see of each other
constexpr int kViewPoints = 60;         // of a place, to tell how much of a view is shared
constexpr double kTurned = 0.7;         // cosine between directions of view
constexpr std::size_t kByPose = 2;      // of each keyframe

using KeyframeMap = std::span<const MapKeyframe>;

const MapKeyframe& key(KeyframeMap map, std::int64_t id) {
  return map[static_cast<std::size_t>(id)];
}

SE3 mapped_motion(KeyframeMap map, std::int64_t from, std::int64_t to) {
  return inverse(key(map, from).world_from_camera) * key(map, to).world_from_camera;
}

// Whether the map tells the same as an aligned link, as far as the link can tell.
bool tells_nothing_new(KeyframeMap map, const LinkReport& link) {
  if (key(map, link.from).segment != key(map, link.to).segment) return false;
  const Vector6d error = log(inverse(link.from_pose_to) * mapped_motion(map, link.from, link.to));
  return error.dot(graph_information(link) * error) < kNothingNew;
}

// Share of some of a place's points that lie in the other's image.
double seen_share(const Place& of, const SE3& other_from_this, const Camera& camera) {
  const std::size_t step = std::max<std::size_t>(1, of.points.size() / kViewPoints);
  int seen = 0, all = 0;
  for (std::size_t i = 0; i < of.points.size(); i += step) {
    const Eigen::Vector3d p = other_from_this * of.points[i].cast<double>();
    ++all;
    const double z = static_cast<double>(of.points[i].z());
    if (p.z() < 0.5 * z || p.z() > 2 * z) continue;  // too different in scale
    const Eigen::Vector2d pixel = project(camera, p);
    seen += pixel.x() > 0 && pixel.y() > 0 && pixel.x() < camera.width - 1 &&
                    pixel.y() < camera.height - 1
                ? 1
                : 0;
  }
  return all > 0 ? static_cast<double>(seen) / all : 0.0;
}

double shared_view(const Place& from, const Place& to, const SE3& from_pose_to,
                   const Camera& camera) {
  if (from_pose_to.rotation.toRotationMatrix()(2, 2) < kTurned) return 0;
  const double share = seen_share(to, from_pose_to, camera);
  return share < kView ? share : std::min(share, seen_share(from, inverse(from_pose_to), camera));
}

// Of candidates whose motion is found, at most so many stay: those of each keyframe with most
// inliers first, and of these, spread evenly over the recording.
void choose_verified(std::vector<std::vector<LinkReport>>& found, int per_keyframe, int most) {
  std::vector<std::pair<std::size_t, LinkReport*>> chosen;  // by rank
  for (std::vector<LinkReport>& reports : found) {
    std::vector<LinkReport*> with_motion;
    for (LinkReport& report : reports)
      if (report.status == LinkStatus::kAccepted) with_motion.push_back(&report);
    std::stable_sort(with_motion.begin(), with_motion.end(),
                     [](const auto* a, const auto* b) { return a->inliers > b->inliers; });
    for (std::size_t rank = 0; rank < with_motion.size(); ++rank) {
      with_motion[rank]->status = LinkStatus::kNotTried;
      if (rank < static_cast<std::size_t>(per_keyframe))
        chosen.emplace_back(rank, with_motion[rank]);
    }
  }
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto limit = static_cast<std::size_t>(most);
  const std::size_t count = std::min(limit, chosen.size());
  for (std::size_t k = 0; k < count; ++k)
    chosen[k * chosen.size() / count].second->status = LinkStatus::kAccepted;
}

std::vector<LinkReport> joined(const std::vector<std::vector<LinkReport>>& parts) {
  std::vector<LinkReport> all;
  for (const std::vector<LinkReport>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

LinkSearch::LinkSearch(const std::vector<Place>& places, const Camera& camera,
                       const SearchOptions& options)
    : places_(places),
      camera_(camera),
      options_(options),
      signatures_(places.size()),
      has_signature_(places.size(), false) {}

void LinkSearch::make_signatures(std::size_t every) {
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < places_.size(); i += every)
    if (!has_signature_[i]) missing.push_back(i);
  for_each_index(static_cast<int>(missing.size()), options_.threads, [&](int k) {
    const std::size_t i = missing[static_cast<std::size_t>(k)];
    signatures_[i] = make_signature(places_[i], camera_);
  });
  for (const std::size_t i : missing) has_signature_[i] = true;
}

std::vector<LinkReport> LinkSearch::by_looks(KeyframeMap map, std::size_t every, int most_verified,
                                             std::size_t below) {
  make_signatures(every);
  PlaceIndex index;  // by position in places_
  std::vector<std::size_t> searched;
  for (std::size_t i = 0; i < places_.size(); i += every) {
    index.add(static_cast<std::int64_t>(i), signatures_[i].code);
    if (i >= below) searched.push_back(i);
  }
  std::vector<std::vector<LinkReport>> found(searched.size());
  for_each_index(static_cast<int>(searched.size()), options_.threads, [&](int k) {
    const std::size_t to = searched[static_cast<std::size_t>(k)];
    found[static_cast<std::size_t>(k)] = candidates_of(map, index, to, below > 0 ? below : to);
  });
  choose_verified(found, options_.loops.verified, most_verified);
  for_each_index(static_cast<int>(searched.size()), options_.threads,
                 [&](int k) { verify(map, found[static_cast<std::size_t>(k)]); });
  return joined(found);
}

// With a motion by their corners where there is one.
std::vector<LinkReport> LinkSearch::candidates_of(KeyframeMap map, const PlaceIndex& index,
                                                  std::size_t to, std::size_t below) const {
  std::vector<LinkReport> reports;
  for (const PlaceMatch& match : similar_places(map, index, to, below)) {
    const auto from = static_cast<std::size_t>(match.id);
    LinkReport report{.from = places_[from].id, .to = places_[to].id};
    report.similarity = match.similarity;
    const std::optional<SE3> motion = motion_of_corners(
        signatures_[from].features, signatures_[to].features, options_.links, report);
    if (motion) {
      report.from_pose_to = *motion;
      report.status = differs_little(map, report) ? LinkStatus::kKnown : LinkStatus::kAccepted;
    }
    reports.push_back(report);
  }
  return reports;
}

// The most similar places of other segments and of earlier visits, one of each visit.
std::vector<PlaceMatch> LinkSearch::similar_places(KeyframeMap map, const PlaceIndex& index,
                                                   std::size_t to, std::size_t below) const {
  const LoopOptions& loops = options_.loops;
  std::vector<PlaceMatch> chosen;
  const auto most = static_cast<std::size_t>(loops.place_candidates);
  const std::int64_t id = places_[to].id;
  for (const PlaceMatch& match :
       index.search(signatures_[to].code, static_cast<std::int64_t>(below),
                    8 * most + static_cast<std::size_t>(loops.recent))) {
    if (chosen.size() == most || match.similarity < loops.min_similarity) break;
    const std::int64_t other = places_[static_cast<std::size_t>(match.id)].id;
    const bool is_joined = key(map, other).segment == key(map, id).segment;
    if (is_joined && id - other <= loops.recent) continue;
    const auto is_near = [&](const PlaceMatch& c) {
      return is_joined && std::abs(places_[static_cast<std::size_t>(c.id)].id - other) < kSameVisit;
    };
    if (std::none_of(chosen.begin(), chosen.end(), is_near)) chosen.push_back(match);
  }
  return chosen;
}

// By corners alone, which tell a motion to a centimetre or two.
bool LinkSearch::differs_little(KeyframeMap map, const LinkReport& report) const {
  if (key(map, report.from).segment != key(map, report.to).segment) return false;
  const LoopOptions& loops = options_.loops;
  const SE3 mapped = mapped_motion(map, report.from, report.to);
  const SE3 error = inverse(mapped) * report.from_pose_to;
  return error.translation.norm() <
             loops.known_translation + loops.known_share * mapped.translation.norm() &&
         rotation_angle(error) < loops.known_rotation + loops.known_share * rotation_angle(mapped);
}

const Place& LinkSearch::place_of(std::int64_t id) const {
  return *std::lower_bound(places_.begin(), places_.end(), id,
                           [](const Place& place, std::int64_t other) { return place.id < other; });
}

// Aligns those of one keyframe whose motion is found.
void LinkSearch::verify(KeyframeMap map, std::vector<LinkReport>& reports) const {
  std::optional<KeyframeView> to;
  for (LinkReport& report : reports) {
    if (report.status != LinkStatus::kAccepted) continue;
    if (!to) to = make_view(keyframe_of(place_of(report.to)), camera_, options_.tracking);
    const LinkReport before = report;
    const KeyframeView from =
        make_view(keyframe_of(place_of(report.from)), camera_, options_.tracking);
    report = verify_link(from, *to, report.from_pose_to, options_.tracking, options_.links);
    report.similarity = before.similarity;
    report.matches = std::max(report.matches, before.matches);
    report.inliers = std::max(report.inliers, before.inliers);
    if (report.status == LinkStatus::kAccepted &&
        key(map, report.from).segment != key(map, report.to).segment) {
      const auto features_of = [this](const Place& place) -> const std::vector<CornerFeature>& {
        return signatures_[static_cast<std::size_t>(&place - places_.data())].features;
      };
      report.alike = std::min(
          alike_share(features_of(place_of(report.from)), to->frame, inverse(report.from_pose_to)),
          alike_share(features_of(place_of(report.to)), from.frame, report.from_pose_to));
    }
    if (report.status == LinkStatus::kAccepted && tells_nothing_new(map, report))
      report.status = LinkStatus::kKnown;
  }
}

std::vector<LinkReport> LinkSearch::by_pose(KeyframeMap map, std::span<const LinkReport> tried,
                                            int most_verified) const {
  std::set<std::pair<std::int64_t, std::int64_t>> aligned;
  for (const LinkReport& link : tried)
    if (link.status != LinkStatus::kNoMotion && link.status != LinkStatus::kFewMatches)
      aligned.emplace(link.from, link.to);
  std::vector<std::vector<LinkReport>> found(places_.size());
  for_each_index(static_cast<int>(places_.size()), options_.threads, [&](int i) {
    const auto t = static_cast<std::size_t>(i);
    const Place& to = places_[t];
    std::vector<std::pair<double, std::size_t>> views;  // negated: the best first
    for (std::size_t f = 0; f < t; ++f) {
      const Place& from = places_[f];
      if (to.id - from.id <= options_.loops.recent ||
          key(map, from.id).segment != key(map, to.id).segment ||
          aligned.contains({from.id, to.id}))
        continue;
      const double view = shared_view(from, to, mapped_motion(map, from.id, to.id), camera_);
      if (view >= kView) views.emplace_back(-view, f);
    }
    std::sort(views.begin(), views.end());
    for (const auto& [view, f] : views) {
      const std::int64_t other = places_[f].id;
      if (found[t].size() == kByPose) break;
      if (std::any_of(found[t].begin(), found[t].end(), [&](const LinkReport& link) {
            return std::abs(link.from - other) < kSameVisit;
          }))
        continue;
      LinkReport report{.from = other, .to = to.id, .status = LinkStatus::kAccepted};
      report.from_pose_to = mapped_motion(map, other, to.id);
      found[t].push_back(report);
    }
  });
  choose_verified(found, static_cast<int>(kByPose), most_verified);
  for (std::vector<LinkReport>& reports : found)
    std::erase_if(reports, [](const auto& r) { return r.status == LinkStatus::kNotTried; });
  for_each_index(static_cast<int>(places_.size()), options_.threads,
                 [&](int i) { verify(map, found[static_cast<std::size_t>(i)]); });
  return joined(found);
}

std::vector<LinkReport> find_links(const std::vector<Place>& places, KeyframeMap map,
                                   const Camera& camera, const AlignOptions& tracking,
                                   const LinkOptions& links, const LoopOptions& loops, int threads,
                                   std::size_t first_new) {
  LinkSearch search(places, camera,
                    {.tracking = tracking, .links = links, .loops = loops, .threads = threads});
  return search.by_looks(map, 1, loops.most_verified, first_new);
}

}  // namespace edvo
