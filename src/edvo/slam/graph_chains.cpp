// SPDX-License-Identifier: MIT
#include "edvo/slam/graph_chains.hpp"

#include <Eigen/Cholesky>

#include <utility>

namespace edvo {
namespace {

constexpr int kIterations = 3;      // of sharing a chain's error
constexpr double kRounding = 1e-9;  // [m], [rad] a pose that moves by less stays as it is

bool is_positive(const Matrix6d& information) {
  return information.llt().info() == Eigen::Success;
}

bool is_odometry(const GraphLink& link) {
  return link.kind == LinkKind::kOdometry && link.enabled;
}

}  // namespace

// Those that loops touch, ends and branches of the odometry, and the first of each part, which
// holds it in place.
std::vector<bool> GraphChains::kept_nodes(const PoseGraph& whole, const LinksByNode& odometry) {
  std::vector<bool> kept(whole.world_from_node.size(), false);
  for (const GraphLink& link : whole.links)
    if (!is_odometry(link) || !is_positive(link.information))
      kept[static_cast<std::size_t>(link.from)] = kept[static_cast<std::size_t>(link.to)] = true;
  for (std::size_t node = 0; node < kept.size(); ++node)
    if (odometry[node].size() != 2) kept[node] = true;
  const std::vector<int> part = connected_parts(whole);
  for (std::size_t node = 0; node < kept.size(); ++node)
    if (part[node] == static_cast<int>(node)) kept[node] = true;
  return kept;
}

GraphChains::Chain GraphChains::chain_along(const PoseGraph& whole, const LinksByNode& odometry,
                                            const std::vector<bool>& kept, int from,
                                            std::size_t link) {
  Chain chain{.from = from};
  int node = from;
  while (true) {
    const GraphLink& next = whole.links[link];
    const Matrix6d covariance = next.information.inverse();
    if (next.from == node) {
      chain.steps.push_back(
          {.node = next.to, .motion = next.from_pose_to, .covariance = covariance});
    } else {
      const Matrix6d turned = adjoint(next.from_pose_to);
      chain.steps.push_back({.node = next.from,
                             .motion = inverse(next.from_pose_to),
                             .covariance = turned * covariance * turned.transpose()});
    }
    node = chain.steps.back().node;
    if (kept[static_cast<std::size_t>(node)]) break;
    const std::vector<std::size_t>& both = odometry[static_cast<std::size_t>(node)];
    link = both[0] == link ? both[1] : both[0];
  }
  for (auto step = chain.steps.rbegin(); step != chain.steps.rend(); ++step) {
    step->at_end = adjoint(inverse(chain.motion));
    chain.covariance += step->at_end * step->covariance * step->at_end.transpose();
    chain.motion = step->motion * chain.motion;
  }
  return chain;
}

GraphChains::GraphChains(const PoseGraph& whole) {
  LinksByNode odometry(whole.world_from_node.size());
  for (std::size_t i = 0; i < whole.links.size(); ++i) {
    if (!is_odometry(whole.links[i])) continue;
    odometry[static_cast<std::size_t>(whole.links[i].from)].push_back(i);
    odometry[static_cast<std::size_t>(whole.links[i].to)].push_back(i);
  }
  const std::vector<bool> kept = kept_nodes(whole, odometry);
  std::vector<int> place(kept.size(), -1);  // in the reduced graph
  for (std::size_t node = 0; node < kept.size(); ++node) {
    if (!kept[node]) continue;
    place[node] = static_cast<int>(whole_node_.size());
    whole_node_.push_back(static_cast<int>(node));
    reduced_.world_from_node.push_back(whole.world_from_node[node]);
  }
  const auto add = [&](GraphLink link) {
    link.from = place[static_cast<std::size_t>(link.from)];
    link.to = place[static_cast<std::size_t>(link.to)];
    reduced_.links.push_back(std::move(link));
  };
  for (std::size_t i = 0; i < whole.links.size(); ++i) {
    if (is_odometry(whole.links[i])) continue;
    whole_link_.push_back(i);
    add(whole.links[i]);
  }
  for (const int from : whole_node_)
    for (const std::size_t link : odometry[static_cast<std::size_t>(from)]) {
      Chain chain = chain_along(whole, odometry, kept, from, link);
      const int to = chain.steps.back().node;
      if (to <= from) continue;  // each is met from both ends; odometry has no rings
      Matrix6d information = chain.covariance.inverse();
      add({.from = from,
           .to = to,
           .from_pose_to = chain.motion,
           .information = 0.5 * (information + information.transpose()),
           .kind = LinkKind::kOdometry});
      chains_.push_back(std::move(chain));
    }
}

void GraphChains::restore(PoseGraph& whole) const {
  for (std::size_t i = 0; i < whole_link_.size(); ++i)
    whole.links[whole_link_[i]].enabled = reduced_.links[i].enabled;
  std::vector<bool> moved(whole.world_from_node.size(), false);
  for (std::size_t i = 0; i < whole_node_.size(); ++i) {
    const auto node = static_cast<std::size_t>(whole_node_[i]);
    SE3& pose = whole.world_from_node[node];
    moved[node] = log(inverse(pose) * reduced_.world_from_node[i]).norm() > kRounding;
    if (moved[node]) pose = reduced_.world_from_node[i];
  }
  const auto pose = [&](int node) -> SE3& {
    return whole.world_from_node[static_cast<std::size_t>(node)];
  };
  for (const Chain& chain : chains_) {
    if (chain.steps.size() == 1) continue;
    const int last = chain.steps.back().node;
    const SE3 start = pose(chain.from), end = pose(last);
    std::vector<Vector6d> errors(chain.steps.size(), Vector6d::Zero());
    SE3 reached = start * chain.motion;
    const bool is_right = log(inverse(reached) * end).norm() < kRounding;
    if (is_right && !moved[static_cast<std::size_t>(chain.from)] &&
        !moved[static_cast<std::size_t>(last)])
      continue;
    for (int i = 0; i < kIterations; ++i) {
      const Vector6d share = chain.covariance.ldlt().solve(log(inverse(reached) * end));
      reached = start;
      for (std::size_t k = 0; k < chain.steps.size(); ++k) {
        const Step& step = chain.steps[k];
        errors[k] += step.covariance * step.at_end.transpose() * share;
        reached = reached * step.motion * exp(errors[k]);
        if (k + 1 < chain.steps.size()) pose(step.node) = reached;
      }
    }
  }
}

}  // namespace edvo
