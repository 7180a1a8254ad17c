// SPDX-License-Identifier: MIT
// The pose graph: keyframe poses that agree best with measured motions between them, and the tests
// by which a wrong measurement is found and switched off.
#pragma once

#include "edvo/core/se3.hpp"

#include <Eigen/SparseCholesky>
#include <vector>

namespace edvo {

enum class LinkKind { kOdometry, kLoop };

// A measured motion between two nodes.
struct GraphLink {
  int from = 0, to = 0;                     // nodes
  SE3 from_pose_to;                         // x_from = from_pose_to * x_to
  Matrix6d information = Matrix6d::Zero();  // inverse covariance of xi in from_pose_to * exp(xi)
  LinkKind kind = LinkKind::kOdometry;
  bool enabled = true;  // a loop that fails is switched off, never erased
};

struct PoseGraph {
  std::vector<SE3> world_from_node;
  std::vector<GraphLink> links;
};

enum class GraphStatus {
  kConverged,
  kIterationLimit,
  kNotFinite,  // a pose, measurement or step was not finite; the poses are as before
};

struct GraphOptions {
  int max_iterations = 50;
  double cost_tolerance = 1e-6;  // share of the cost gained, below which it has converged
  // Chi-square of 6 degrees of freedom at 0.999.
  double gate = 22.46;
};

struct GraphSummary {
  GraphStatus status = GraphStatus::kConverged;
  int iterations = 0;  // linearizations
  double initial_cost = 0, cost = 0;
};

// Squared Mahalanobis distance of a measurement from the present poses.
[[nodiscard]] double chi_square(const PoseGraph& graph, const GraphLink& link);

// For each node the lowest node that enabled links connect it with.
[[nodiscard]] std::vector<int> connected_parts(const PoseGraph& graph);

// Lowers the sum of the enabled links' chi-squares / 2 by Levenberg-Marquardt. The first node of
// each connected part stays where it is. The order of work is fixed: same bits from run to run.
GraphSummary optimize(PoseGraph& graph, const GraphOptions& options = {});

// What the enabled links tell of the motion between any two nodes, about the present poses.
class GraphMarginals {
 public:
  explicit GraphMarginals(const PoseGraph& graph);

  // Covariance of xi in from_pose_to * exp(xi); infinite where nothing connects the two.
  [[nodiscard]] Matrix6d relative_covariance(int from, int to);

  // Squared Mahalanobis distance of a measurement from what the other links tell, both uncertain:
  // the chi-square of the cycle that the link closes.
  [[nodiscard]] double cycle_chi_square(const GraphLink& link);

 private:
  std::vector<SE3> world_from_node_;
  std::vector<int> part_, column_;  // of nodes; column -1: held in place
  bool valid_ = false;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  Eigen::VectorXd diagonal_;  // of the factor
  // Scratch, zero and false between calls.
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor> rows_;
  std::vector<bool> on_way_;
};

// Decides anew which loop links hold, and optimizes with those. Links are tried by the uncertainty
// of the cycle that they close, the surest first, against all that is accepted by then (after Wu
// and others 2024, incremental probabilistic consensus). After each optimization the worst link
// beyond the gate is switched off; at the end, those that now agree are switched on again.
GraphSummary select_links(PoseGraph& graph, const GraphOptions& options = {});

}  // namespace edvo
