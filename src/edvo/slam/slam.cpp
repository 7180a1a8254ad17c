// SPDX-License-Identifier: MIT
#include "edvo/slam/slam.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace edvo {
namespace {

constexpr std::size_t kProbeEvery = 3;  // keyframes
constexpr KeyframeId kMeasuredAt = 4;   // keyframes later a step is measured
constexpr int kRounds = 2;              // of comparing what is near after loops were closed
constexpr double kVerified = 0.05;      // [m], [rad] by which a step may differ from its alignment
constexpr double kGuessSigma = 0.5;     // [m], [rad] of a step that is not verified

// Drops the one, not the first nor the last, without which the least gap is left; returns its id.
std::int64_t drop_one(std::vector<Place>& places, const Map& map) {
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
  const std::int64_t id = places[best].id;
  places.erase(places.begin() + static_cast<std::ptrdiff_t>(best));
  return id;
}

SearchOptions search_options(const Config& config, const SlamConfig& slam, int threads) {
  return {
      .tracking = config.tracking, .links = slam.links, .loops = slam.loops, .threads = threads};
}

}  // namespace

Slam::Slam(const DistortedCamera& camera, const Config& config, const SlamConfig& slam,
           std::unique_ptr<EdgeDetector> detector)
    : odometry_(camera, config, std::move(detector)),
      camera_(camera.pinhole),
      config_(config),
      slam_(slam),
      relocalizer_(camera_, search_options(config, slam, 1)) {}

FrameResult Slam::process(const PreparedImage& image) {
  FrameResult result = odometry_.process(image);
  if (result.status == FrameStatus::kLost) lost_since_keyframe_ = true;
  if (result.new_keyframe) add_place(result);
  relocalizer_.look_for(image.frame, result, odometry_.map(), places_);
  return result;
}

void Slam::add_place(const FrameResult& result) {
  const bool after_loss = std::exchange(lost_since_keyframe_, false);
  if (result.keyframe != *result.new_keyframe) {
    if (after_loss) after_loss_.push_back(steps_.size());
    steps_.push_back(
        {.from = result.keyframe, .to = *result.new_keyframe, .information = result.information});
  }
  measure_steps(*result.new_keyframe - kMeasuredAt, *result.new_keyframe - kMeasuredAt);
  const KeyframePtr keyframe =
      slam_.keep_colour ? odometry_.newest_keyframe() : odometry_.newest_keyframe_in_gray();
  places_.push_back(make_place(*keyframe, slam_.keep_colour));
  relocalizer_.add(places_.back(), result.segment);
  if (places_.size() > static_cast<std::size_t>(config_.window.candidate_keyframes))
    relocalizer_.drop(drop_one(places_, odometry_.map()));
}

// Those that lead to one of these keyframes.
void Slam::measure_steps(KeyframeId first, KeyframeId last) {
  const Map& map = odometry_.map();
  for (auto step = steps_.rbegin(); step != steps_.rend() && step->to >= first; ++step)
    if (step->to <= last)
      step->from_pose_to =
          inverse(map[step->from].world_from_camera) * map[step->to].world_from_camera;
}

// The camera may have been moved to where things look similar: what cannot be verified tells
// hardly anything.
void Slam::doubt_steps_after_loss() {
  const auto place = [this](KeyframeId id) {
    return std::find_if(places_.begin(), places_.end(), [id](const auto& p) { return p.id == id; });
  };
  for (const std::size_t i : std::exchange(after_loss_, {})) {
    OdometryStep& step = steps_[i];
    const auto from = place(step.from), to = place(step.to);
    if (from == places_.end() || to == places_.end()) continue;
    const LinkReport report = verify_link(make_view(keyframe_of(*from), camera_, config_.tracking),
                                          make_view(keyframe_of(*to), camera_, config_.tracking),
                                          step.from_pose_to, config_.tracking, slam_.links);
    const SE3 error = inverse(step.from_pose_to) * report.from_pose_to;
    if (report.status != LinkStatus::kAccepted || error.translation.norm() > kVerified ||
        rotation_angle(error) > kVerified)
      step.information = Matrix6d::Identity() / (kGuessSigma * kGuessSigma);
  }
}

// A single segment is probed at first: if its map tells all that is seen again, there is no drift
// to find. Where the map was bent to fit what was seen before, the error belongs to all of the way
// since then. Where loops were closed, keyframes that now are near each other are compared as well.
void Slam::search_places(std::vector<MapKeyframe>& keyframes, int threads) {
  LinkSearch search(places_, camera_, search_options(config_, slam_, threads));
  const auto is_new = [](const LinkReport& link) { return link.status == LinkStatus::kAccepted; };
  const auto correct = [&] {  // returns how many links are refused
    for (LinkReport& link : links_)
      if (link.status == LinkStatus::kCycle || link.status == LinkStatus::kAlone)
        link.status = LinkStatus::kAccepted;
    join_segments(keyframes, links_);
    close_loops(keyframes, steps_, links_);
    return std::count_if(links_.begin(), links_.end(),
                         [](const LinkReport& link) { return link.status == LinkStatus::kCycle; });
  };
  const bool single = std::all_of(keyframes.begin(), keyframes.end(), [&](const MapKeyframe& key) {
    return key.segment == keyframes.front().segment;
  });
  const bool bent = is_bent(keyframes, steps_);
  if (single && !bent) {
    links_ = search.by_looks(keyframes, kProbeEvery, slam_.loops.probes);
    if (std::none_of(links_.begin(), links_.end(), is_new)) return;
  }
  links_ = search.by_looks(keyframes, 1, slam_.loops.most_verified);
  links_.insert(links_.end(), relocalizer_.links().begin(), relocalizer_.links().end());
  if (bent) {
    const std::vector<LinkReport> near =
        search.by_pose(keyframes, links_, slam_.loops.most_verified);
    links_.insert(links_.end(), near.begin(), near.end());
    // Steps that are less sure than they say contradict right links: then the map is believed.
    const auto keyframes_before = keyframes;
    const auto links_before = links_;
    const auto steps_early = steps_;
    measure_steps(0, static_cast<KeyframeId>(keyframes.size()) - 1);
    const auto steps_late = steps_;
    const auto refused_with = [&](const std::vector<OdometryStep>& steps) {
      steps_ = steps;
      keyframes = keyframes_before;
      links_ = links_before;
      return correct();
    };
    const auto refused_late = refused_with(steps_late);
    if (refused_with(steps_early) > refused_late) refused_with(steps_late);
  } else {
    correct();
  }
  for (int round = 0; round < kRounds && std::any_of(links_.begin(), links_.end(), is_new);
       ++round) {
    const std::vector<LinkReport> more =
        search.by_pose(keyframes, links_, slam_.loops.most_verified);
    links_.insert(links_.end(), more.begin(), more.end());
    if (std::none_of(more.begin(), more.end(), is_new)) break;
    correct();
  }
}

void Slam::finish(int threads) {
  odometry_.settle();
  const auto newest = static_cast<KeyframeId>(odometry_.map().keyframes().size()) - 1;
  measure_steps(newest - kMeasuredAt + 1, newest);
  doubt_steps_after_loss();
  std::vector<MapKeyframe> keyframes = odometry_.map().keyframes();
  links_.clear();
  if (!places_.empty()) search_places(keyframes, threads);
  for (LinkReport& link : links_)
    if (!link.information.isZero()) weaken_link(link);
  odometry_.correct(keyframes);
  odometry_.finish(threads);
}

}  // namespace edvo
