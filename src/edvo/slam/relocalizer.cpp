// SPDX-License-Identifier: MIT
#include "edvo/slam/relocalizer.hpp"

#include "edvo/slam/map_correction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace edvo {
namespace {

constexpr int kEveryFrame = 30;     // frames of a young segment; later ones only as keyframes
constexpr double kAgreeing = 0.05;  // [m], [rad] between what two frames tell
constexpr int kCell = 10;           // [px] of each, the pixel of most gradient is aligned
constexpr int kLeastGradient = 8;   // [grey levels / px]

// What verification needs of a frame that is no keyframe.
KeyframePtr keyframe_of(const Frame& frame, std::int64_t id) {
  auto keyframe = std::make_shared<Keyframe>();
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  keyframe->id = id;
  keyframe->stamp = frame.stamp;
  keyframe->gray = gray;
  keyframe->depth = frame.depth.undistorted();
  const Camera& camera = frame.levels.front().camera;
  for (int top = 2; top + kCell < gray.rows - 2; top += kCell)
    for (int left = 2; left + kCell < gray.cols - 2; left += kCell) {
      int most = kLeastGradient, best_x = -1, best_y = -1;
      for (int y = top; y < top + kCell; ++y)
        for (int x = left; x < left + kCell; ++x) {
          const int gradient = (std::abs(gray(y, x + 1) - gray(y, x - 1)) +
                                std::abs(gray(y + 1, x) - gray(y - 1, x))) /
                               2;
          if (gradient <= most || !(keyframe->depth(y, x) > 0)) continue;
          most = gradient;
          best_x = x;
          best_y = y;
        }
      if (best_x < 0) continue;
      keyframe->points.push_back(
          {.position = back_project(camera, best_x, best_y,
                                    static_cast<double>(keyframe->depth(best_y, best_x)))
                           .cast<float>()});
    }
  return keyframe;
}

}  // namespace

void Relocalizer::add(const Place& place, int segment) {
  kept_[place.id] = {.segment = segment, .code = make_fern_code(place), .features = {}};
}

void Relocalizer::drop(std::int64_t id) {
  kept_.erase(id);
}

MapFrame Relocalizer::frame_of(int segment) const {
  const auto found = found_.find(segment);
  return found == found_.end() ? MapFrame{.segment = segment, .map_from_odometry = {}}
                               : found->second;
}

void Relocalizer::look_for(const Frame& frame, const FrameResult& result, const Map& map,
                           const std::vector<Place>& places) {
  if (result.segment == 0 || result.status == FrameStatus::kLost) return;
  if (result.segment < young_ || found_.contains(result.segment)) return;
  if (result.segment > young_) {
    young_ = result.segment;
    tries_ = 0;
    sightings_.clear();
  }
  if (++tries_ > kEveryFrame && !result.new_keyframe) return;
  const KeyframeId host = result.new_keyframe.value_or(result.keyframe);
  std::optional<LinkReport> link = locate(frame, host, result.segment, places);
  if (!link) return;
  const MapKeyframe& seen = map[link->from];
  sightings_.push_back({.segment = seen.segment,
                        .found_from_segment = seen.world_from_camera * link->from_pose_to *
                                              inverse(result.world_from_camera),
                        .camera = result.world_from_camera,
                        .is_sure = is_sure(*link)});
  if (!is_sure(*link)) return;
  if (!result.new_keyframe) {
    const SE3 camera_from_keyframe = inverse(result.keyframe_from_camera);
    const Matrix6d across = adjoint(camera_from_keyframe);
    link->from_pose_to = link->from_pose_to * camera_from_keyframe;
    link->information = across.transpose() * link->information * across;
  }
  links_.push_back(*link);
  settle(result.segment);
}

// The keyframe of another segment that shows what a frame shows; a sure one if there is one.
std::optional<LinkReport> Relocalizer::locate(const Frame& frame, std::int64_t keyframe,
                                              int segment, const std::vector<Place>& places) {
  PlaceIndex index;
  for (const auto& [id, kept] : kept_)
    if (kept.segment != segment && id < keyframe) index.add(id, kept.code);
  if (index.size() == 0) return std::nullopt;
  const auto place_of = [&](std::int64_t id) -> const Place& {
    return *std::lower_bound(places.begin(), places.end(), id,
                             [](const Place& p, std::int64_t other) { return p.id < other; });
  };
  const KeyframePtr query = keyframe_of(frame, keyframe);
  const std::vector<CornerFeature> features = describe_corners(frame, kFeaturesPerKeyframe);
  std::vector<LinkReport> candidates;
  for (const PlaceMatch& match :
       index.search(make_fern_code(query->gray, query->depth), keyframe,
                    static_cast<std::size_t>(options_.loops.place_candidates))) {
    if (match.similarity < options_.loops.min_similarity) break;
    Kept& kept = kept_[match.id];
    if (kept.features.empty()) kept.features = make_signature(place_of(match.id), camera_).features;
    LinkReport report{.from = match.id, .to = keyframe};
    report.similarity = match.similarity;
    const auto motion = motion_of_corners(kept.features, features, options_.links, report);
    if (!motion) continue;
    report.from_pose_to = *motion;
    candidates.push_back(report);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.inliers > b.inliers; });
  candidates.resize(std::min(candidates.size(), static_cast<std::size_t>(options_.loops.verified)));
  std::optional<KeyframeView> to;
  std::optional<LinkReport> unsure;
  for (const LinkReport& candidate : candidates) {
    if (!to) to = make_view(query, frame, camera_, options_.tracking);
    const KeyframeView from =
        make_view(edvo::keyframe_of(place_of(candidate.from)), camera_, options_.tracking);
    LinkReport report =
        verify_link(from, *to, candidate.from_pose_to, options_.tracking, options_.links);
    if (report.status != LinkStatus::kAccepted) continue;
    report.alike = std::min(
        alike_share(kept_[candidate.from].features, to->frame, inverse(report.from_pose_to)),
        alike_share(features, from.frame, report.from_pose_to));
    report.similarity = candidate.similarity;
    report.matches = candidate.matches;
    report.inliers = candidate.inliers;
    if (is_sure(report)) return report;
    if (!unsure) unsure = report;
  }
  return unsure;
}

// Believes what two frames or more tell surely, and more than contradict it, unless so many others
// tell it unsurely that the sure ones may be chance.
void Relocalizer::settle(int segment) {
  const Sighting& last = sightings_.back();
  const auto agrees = [&](const Sighting& other) {
    if (other.segment != last.segment) return false;
    const SE3 error =
        inverse(last.found_from_segment * last.camera) * (other.found_from_segment * last.camera);
    return error.translation.norm() < kAgreeing && rotation_angle(error) < kAgreeing;
  };
  int sure = 0, unsure = 0, against = 0;
  for (const Sighting& sighting : sightings_) {
    if (agrees(sighting))
      ++(sighting.is_sure ? sure : unsure);
    else if (sighting.is_sure)
      ++against;
  }
  if (sure < 2 || sure <= against || unsure > kMostUnsure * sure) return;
  const MapFrame into = frame_of(last.segment);
  found_[segment] = {.segment = into.segment,
                     .map_from_odometry = into.map_from_odometry * last.found_from_segment};
}

}  // namespace edvo
