// SPDX-License-Identifier: MIT
// Most keyframes of a long walk are seen once: between two that loops or branches hold, a chain of
// odometry is one link.
#pragma once

#include "edvo/slam/pose_graph.hpp"

#include <vector>

namespace edvo {

// A pose graph and the smaller one that tells the same of the nodes that matter, to first order in
// the errors of odometry.
class GraphChains {
 public:
  explicit GraphChains(const PoseGraph& whole);

  PoseGraph& reduced() { return reduced_; }

  // Takes over what was found out: poses, also of the nodes within chains, whose steps share the
  // error by their covariances, and which loops are enabled.
  void restore(PoseGraph& whole) const;

 private:
  struct Step {
    int node = 0;  // that it leads to
    SE3 motion;    // from the node before
    Matrix6d covariance = Matrix6d::Zero();
    Matrix6d at_end = Matrix6d::Zero();  // adjoint, of its error at the chain's end
  };
  struct Chain {
    int from = 0;
    std::vector<Step> steps;
    SE3 motion;
    Matrix6d covariance = Matrix6d::Zero();  // of the whole
  };

  using LinksByNode = std::vector<std::vector<std::size_t>>;

  [[nodiscard]] static std::vector<bool> kept_nodes(const PoseGraph& whole,
                                                    const LinksByNode& odometry);
  [[nodiscard]] static Chain chain_along(const PoseGraph& whole, const LinksByNode& odometry,
                                         const std::vector<bool>& kept, int from, std::size_t link);

  PoseGraph reduced_;
  std::vector<int> whole_node_;          // of each node of the reduced graph
  std::vector<std::size_t> whole_link_;  // of each of its first links, the loops
  std::vector<Chain> chains_;            // of its other links
};

}  // namespace edvo
