// SPDX-License-Identifier: MIT
#include "edvo/slam/map_correction.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace edvo {
namespace {

constexpr double kAgreeing = 0.1;  // [m], [rad] between what two links tell of two segments
constexpr int kSupport = 2;        // links that agree, for two segments to be joined
constexpr double kBent = 0.01;     // [m], [rad]

// Sigmas of a step of the odometry beside those that tracking reports.
constexpr double kStepSigma = 0.001;  // [m], [rad]
// Of a link beside those that alignment reports: shares of the difference between its two
// directions and, as alike pixels of a wide baseline hide that they are not the same, of its own
// motion.
constexpr double kLinkTranslation = 0.01, kLinkRotation = 0.006;  // [m], [rad]
constexpr double kLinkDifference = 0.5, kLinkShare = 0.03;

const MapKeyframe& at(const std::vector<MapKeyframe>& keyframes, std::int64_t id) {
  return keyframes[static_cast<std::size_t>(id)];
}

// Of rendered rooms that differ in their textures alone up to 0.45 of the corners look alike; of
// true links of fr1/desk over blurred frames, the median is 0.54.
constexpr double kAlike = 0.5;

struct Join {
  int into = 0, segment = 0;
  SE3 into_from_segment;  // world of the one from that of the other
  int support = 0;        // sure links that agree
  int unsure = 0;         // others that do
  int against = 0;        // sure links between the same two that do not
};

// Between the worlds of two segments, the lower id first.
Join join_by(const std::vector<MapKeyframe>& keyframes, const LinkReport& link) {
  const MapKeyframe &from = at(keyframes, link.from), &to = at(keyframes, link.to);
  Join join{.into = from.segment,
            .segment = to.segment,
            .into_from_segment =
                from.world_from_camera * link.from_pose_to * inverse(to.world_from_camera)};
  if (join.into > join.segment) {
    std::swap(join.into, join.segment);
    join.into_from_segment = inverse(join.into_from_segment);
  }
  return join;
}

bool joins_the_same(const Join& join, const std::vector<MapKeyframe>& keyframes,
                    const LinkReport& link) {
  const Join other = join_by(keyframes, link);
  return other.into == join.into && other.segment == join.segment;
}

bool agree(const Join& join, const std::vector<MapKeyframe>& keyframes, const LinkReport& link) {
  if (!joins_the_same(join, keyframes, link)) return false;
  const Join other = join_by(keyframes, link);
  const MapKeyframe &from = at(keyframes, link.from), &to = at(keyframes, link.to);
  const SE3& pose = (from.segment == join.segment ? from : to).world_from_camera;
  const SE3 error = inverse(join.into_from_segment * pose) * (other.into_from_segment * pose);
  return error.translation.norm() < kAgreeing && rotation_angle(error) < kAgreeing;
}

// The join on which most links agree.
Join best_join(const std::vector<MapKeyframe>& keyframes, const std::vector<LinkReport>& links) {
  std::vector<const LinkReport*> between;
  for (const LinkReport& link : links)
    if (link.status == LinkStatus::kAccepted &&
        at(keyframes, link.from).segment != at(keyframes, link.to).segment)
      between.push_back(&link);
  // Sure ones first: they stand for their pair.
  std::stable_partition(between.begin(), between.end(),
                        [](const LinkReport* link) { return is_sure(*link); });
  std::set<std::pair<std::int64_t, std::int64_t>> pairs;
  std::erase_if(
      between, [&](const LinkReport* link) { return !pairs.emplace(link->from, link->to).second; });
  Join best;
  for (const LinkReport* const link : between) {
    if (!is_sure(*link)) break;
    Join join = join_by(keyframes, *link);
    for (const LinkReport* const other : between) {
      if (agree(join, keyframes, *other))
        ++(is_sure(*other) ? join.support : join.unsure);
      else if (is_sure(*other) && joins_the_same(join, keyframes, *other))
        ++join.against;
    }
    if (join.support > join.against && join.unsure <= kMostUnsure * join.support &&
        join.support > best.support)
      best = join;
  }
  return best;
}

// Information with floors added to its sigmas.
Matrix6d weaken(const Matrix6d& information, double translation_sigma, double rotation_sigma) {
  Matrix6d covariance = information.inverse();
  covariance.diagonal().head<3>().array() += translation_sigma * translation_sigma;
  covariance.diagonal().tail<3>().array() += rotation_sigma * rotation_sigma;
  const Matrix6d weaker = covariance.inverse();
  return 0.5 * (weaker + weaker.transpose());
}

}  // namespace

bool is_sure(const LinkReport& link) {
  return link.alike > kAlike;
}

void join_segments(std::vector<MapKeyframe>& keyframes, std::vector<LinkReport>& links) {
  for (Join join = best_join(keyframes, links); join.support >= kSupport;
       join = best_join(keyframes, links))
    for (MapKeyframe& key : keyframes)
      if (key.segment == join.segment) {
        key.segment = join.into;
        key.world_from_camera = join.into_from_segment * key.world_from_camera;
      }
  for (LinkReport& link : links)
    if (link.status == LinkStatus::kAccepted &&
        at(keyframes, link.from).segment != at(keyframes, link.to).segment)
      link.status = LinkStatus::kAlone;
}

bool is_bent(const std::vector<MapKeyframe>& keyframes, const std::vector<OdometryStep>& steps) {
  return std::any_of(steps.begin(), steps.end(), [&](const OdometryStep& step) {
    const SE3 error = inverse(step.from_pose_to) *
                      inverse(at(keyframes, step.from).world_from_camera) *
                      at(keyframes, step.to).world_from_camera;
    return error.translation.norm() > kBent || rotation_angle(error) > kBent;
  });
}

Matrix6d step_information(const OdometryStep& step) {
  return weaken(step.information, kStepSigma, kStepSigma);
}

Matrix6d graph_information(const LinkReport& link) {
  return weaken(link.information,
                kLinkTranslation + kLinkDifference * link.translation_difference +
                    kLinkShare * link.from_pose_to.translation.norm(),
                kLinkRotation + kLinkDifference * link.rotation_difference +
                    kLinkShare * rotation_angle(link.from_pose_to));
}

void weaken_link(LinkReport& link) {
  link.information = graph_information(link);
}

void close_loops(std::vector<MapKeyframe>& keyframes, const std::vector<OdometryStep>& steps,
                 std::vector<LinkReport>& links) {
  PoseGraph graph;
  for (const MapKeyframe& key : keyframes) graph.world_from_node.push_back(key.world_from_camera);
  const auto add = [&](std::int64_t from, std::int64_t to, const SE3& motion,
                       const Matrix6d& information, LinkKind kind) {
    graph.links.push_back({.from = static_cast<int>(from),
                           .to = static_cast<int>(to),
                           .from_pose_to = motion,
                           .information = information,
                           .kind = kind});
  };
  for (const OdometryStep& step : steps)
    add(step.from, step.to, step.from_pose_to, step_information(step), LinkKind::kOdometry);
  std::vector<LinkReport*> used;
  for (LinkReport& link : links) {
    const bool is_aligned_and_known =
        link.status == LinkStatus::kKnown && !link.information.isZero();
    if (link.status != LinkStatus::kAccepted && !is_aligned_and_known) continue;
    add(link.from, link.to, link.from_pose_to, graph_information(link), LinkKind::kLoop);
    used.push_back(&link);
  }
  const auto is_new = [](const LinkReport* link) { return link->status == LinkStatus::kAccepted; };
  const bool straighten = !used.empty() && is_bent(keyframes, steps);
  if (!straighten && std::none_of(used.begin(), used.end(), is_new)) return;
  const GraphSummary summary = select_links(graph);
  for (std::size_t k = 0; k < used.size(); ++k) {
    const GraphLink& link = graph.links[steps.size() + k];
    used[k]->cycle_chi_square = chi_square(graph, link);
    if (!link.enabled) used[k]->status = LinkStatus::kCycle;
  }
  if (summary.status == GraphStatus::kNotFinite ||
      (!straighten && std::none_of(used.begin(), used.end(), is_new)))
    return;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    keyframes[i].world_from_camera = graph.world_from_node[i];
}

}  // namespace edvo
