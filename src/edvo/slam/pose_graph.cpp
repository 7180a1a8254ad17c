// SPDX-License-Identifier: MIT
#include "edvo/slam/pose_graph.hpp"

#include "edvo/slam/graph_chains.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace edvo {

std::vector<int> connected_parts(const PoseGraph& graph) {
  std::vector<int> part(graph.world_from_node.size());
  std::iota(part.begin(), part.end(), 0);
  const auto root = [&](int node) {
    while (part[static_cast<std::size_t>(node)] != node) {
      int& above = part[static_cast<std::size_t>(node)];
      above = part[static_cast<std::size_t>(above)];
      node = above;
    }
    return node;
  };
  for (const GraphLink& link : graph.links) {
    if (!link.enabled) continue;
    const int a = root(link.from), b = root(link.to);
    part[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  for (std::size_t i = 0; i < part.size(); ++i) part[i] = root(static_cast<int>(i));
  return part;
}

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Factor = Eigen::SimplicialLDLT<SparseMatrix>;

constexpr double kInitialLambda = 1e-6;  // relative to the diagonal: the start is a good one
constexpr double kLargestLambda = 1e8;

// [xi, .], the derivative of the adjoint.
Matrix6d small_adjoint(const Vector6d& xi) {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = hat(xi.tail<3>());
  m.topRightCorner<3, 3>() = hat(xi.head<3>());
  m.bottomRightCorner<3, 3>() = hat(xi.tail<3>());
  return m;
}

// d log(exp(xi) exp(d)) / d d, by its Bernoulli series (Barfoot, eq. 7.80), good to 1e-5 at 1 rad.
Matrix6d right_jacobian_inverse(const Vector6d& xi) {
  const Matrix6d a = small_adjoint(xi);
  const Matrix6d a2 = a * a;
  return Matrix6d::Identity() + 0.5 * a + a2 / 12.0 - a2 * a2 / 720.0 + a2 * a2 * a2 / 30240.0;
}

SE3 relative_pose(const std::vector<SE3>& poses, const GraphLink& link) {
  return inverse(poses[static_cast<std::size_t>(link.from)]) *
         poses[static_cast<std::size_t>(link.to)];
}

Vector6d residual(const std::vector<SE3>& poses, const GraphLink& link) {
  return log(inverse(link.from_pose_to) * relative_pose(poses, link));
}

double total_cost(const PoseGraph& graph, const std::vector<SE3>& poses) {
  double cost = 0;
  for (const GraphLink& link : graph.links) {
    if (!link.enabled) continue;
    const Vector6d r = residual(poses, link);
    cost += 0.5 * r.dot(link.information * r);
  }
  return cost;
}

// First column of each node's unknowns, -1 for the node that holds its part in place.
std::vector<int> unknown_columns(const std::vector<int>& part) {
  std::vector<int> column(part.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (part[i] == static_cast<int>(i)) continue;
    column[i] = next;
    next += 6;
  }
  return column;
}

int unknown_count(const std::vector<int>& column) {
  return 6 * static_cast<int>(
                 std::count_if(column.begin(), column.end(), [](int first) { return first >= 0; }));
}

struct GraphSystem {
  SparseMatrix hessian;  // lower triangle
  Eigen::VectorXd gradient;
  double cost = 0;
};

void add_block(int row, int column, const Matrix6d& block,
               std::vector<Eigen::Triplet<double>>& entries) {
  if (row < 0 || column < 0 || row < column) return;
  for (int c = 0; c < 6; ++c)
    for (int r = row == column ? c : 0; r < 6; ++r)
      entries.emplace_back(row + r, column + c, block(r, c));
}

GraphSystem linearize(const PoseGraph& graph, const std::vector<SE3>& poses,
                      const std::vector<int>& column) {
  const int unknowns = unknown_count(column);
  GraphSystem system;
  system.gradient = Eigen::VectorXd::Zero(unknowns);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(graph.links.size() * 78);
  for (const GraphLink& link : graph.links) {
    if (!link.enabled) continue;
    const Vector6d r = residual(poses, link);
    const Vector6d weighted = link.information * r;
    const Matrix6d J_to = right_jacobian_inverse(r);
    const Matrix6d J_from = -J_to * adjoint(inverse(relative_pose(poses, link)));
    const int from = column[static_cast<std::size_t>(link.from)];
    const int to = column[static_cast<std::size_t>(link.to)];
    add_block(from, from, J_from.transpose() * link.information * J_from, entries);
    add_block(to, to, J_to.transpose() * link.information * J_to, entries);
    const Matrix6d cross = J_from.transpose() * link.information * J_to;
    add_block(from, to, cross, entries);
    add_block(to, from, cross.transpose(), entries);
    if (from >= 0) system.gradient.segment<6>(from) += J_from.transpose() * weighted;
    if (to >= 0) system.gradient.segment<6>(to) += J_to.transpose() * weighted;
    system.cost += 0.5 * r.dot(weighted);
  }
  system.hessian.resize(unknowns, unknowns);
  system.hessian.setFromTriplets(entries.begin(), entries.end());
  return system;
}

std::vector<SE3> moved_by(const std::vector<SE3>& poses, const std::vector<int>& column,
                          const Eigen::VectorXd& step) {
  std::vector<SE3> moved = poses;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (column[i] >= 0) moved[i] = poses[i] * exp(step.segment<6>(column[i]));
  return moved;
}

// Empty where the damped system cannot be solved.
std::optional<Eigen::VectorXd> solve_damped(const GraphSystem& system, double lambda,
                                            Factor& factor) {
  SparseMatrix damped = system.hessian;
  for (int i = 0; i < damped.cols(); ++i) damped.coeffRef(i, i) *= 1 + lambda;
  factor.factorize(damped);
  if (factor.info() != Eigen::Success) return std::nullopt;
  Eigen::VectorXd step = factor.solve(-system.gradient);
  if (!step.allFinite()) return std::nullopt;
  return step;
}

bool all_finite(const PoseGraph& graph) {
  return std::all_of(graph.world_from_node.begin(), graph.world_from_node.end(), is_finite) &&
         std::all_of(graph.links.begin(), graph.links.end(), [](const GraphLink& link) {
           return !link.enabled || (is_finite(link.from_pose_to) && link.information.allFinite());
         });
}

}  // namespace

double chi_square(const PoseGraph& graph, const GraphLink& link) {
  const Vector6d r = residual(graph.world_from_node, link);
  return r.dot(link.information * r);
}

GraphSummary optimize(PoseGraph& graph, const GraphOptions& options) {
  GraphSummary summary;
  if (!all_finite(graph)) return {.status = GraphStatus::kNotFinite};
  std::vector<SE3> poses = graph.world_from_node;
  const std::vector<int> column = unknown_columns(connected_parts(graph));
  GraphSystem system = linearize(graph, poses, column);
  summary = {.iterations = 1, .initial_cost = system.cost, .cost = system.cost};
  if (system.gradient.size() == 0) return summary;
  Factor factor;
  factor.analyzePattern(system.hessian);
  double lambda = kInitialLambda, growth = 2;
  summary.status = GraphStatus::kIterationLimit;
  while (summary.iterations < options.max_iterations) {
    const std::optional<Eigen::VectorXd> step = solve_damped(system, lambda, factor);
    const std::vector<SE3> candidate = step ? moved_by(poses, column, *step) : poses;
    const double cost = step ? total_cost(graph, candidate) : summary.cost;
    ++summary.iterations;
    if (cost < summary.cost) {  // false for NaN
      const double gained = summary.cost - cost;
      poses = candidate;
      summary.cost = cost;
      lambda = std::max(lambda / 3, 1e-9);
      growth = 2;
      if (gained > options.cost_tolerance * (cost + 1e-12)) {
        system = linearize(graph, poses, column);
        continue;
      }
    } else if (step && (cost - summary.cost) > options.cost_tolerance * (summary.cost + 1e-12)) {
      lambda *= growth;
      growth *= 2;
      if (lambda < kLargestLambda) continue;
    } else if (!step) {
      lambda = std::max(1e-4, lambda * 10);
      if (lambda < kLargestLambda) continue;
      return {.status = GraphStatus::kNotFinite, .iterations = summary.iterations};
    }
    summary.status = GraphStatus::kConverged;
    break;
  }
  graph.world_from_node = std::move(poses);
  return summary;
}

GraphMarginals::GraphMarginals(const PoseGraph& graph)
    : world_from_node_(graph.world_from_node),
      part_(connected_parts(graph)),
      column_(unknown_columns(part_)) {
  const GraphSystem system = linearize(graph, world_from_node_, column_);
  if (system.gradient.size() == 0) return;
  factor_.compute(system.hessian);
  valid_ = factor_.info() == Eigen::Success;
  if (!valid_) return;
  diagonal_ = factor_.vectorD();
  rows_.setZero(factor_.rows(), 6);
  on_way_.assign(static_cast<std::size_t>(factor_.rows()), false);
}

Matrix6d GraphMarginals::relative_covariance(int from, int to) {
  const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
  if (from == to) return Matrix6d::Zero();
  if (!valid_ || part_[a] != part_[b])
    return Matrix6d::Identity() * std::numeric_limits<double>::infinity();
  // xi = x_to - Ad(to_from) x_from, of small errors.
  const Matrix6d J_from = -adjoint(inverse(world_from_node_[b]) * world_from_node_[a]);
  // J A^-1 J' is the square of L^-1 J' over D, and L^-1 J' is zero but on the ways from the nodes'
  // columns to the root of the elimination tree, where a column's parent is its first row.
  const SparseMatrix& lower = factor_.matrixL().nestedExpression();
  std::vector<int> way;
  const auto set = [&](int first, const Matrix6d& block) {
    for (int i = 0; first >= 0 && i < 6; ++i) {
      int column = factor_.permutationP().indices()[first + i];
      rows_.row(column) = block.row(i);
      while (column >= 0 && !on_way_[static_cast<std::size_t>(column)]) {
        on_way_[static_cast<std::size_t>(column)] = true;
        way.push_back(column);
        const SparseMatrix::InnerIterator below(lower, column);
        column = below ? static_cast<int>(below.row()) : -1;
      }
    }
  };
  set(column_[a], J_from.transpose());
  set(column_[b], Matrix6d::Identity());
  std::sort(way.begin(), way.end());
  Matrix6d covariance = Matrix6d::Zero();
  for (const int j : way) {
    const Eigen::Matrix<double, 1, 6> row = rows_.row(j);
    for (SparseMatrix::InnerIterator below(lower, j); below; ++below)
      rows_.row(below.row()) -= below.value() * row;
    covariance += row.transpose() * row / diagonal_[j];
    rows_.row(j).setZero();
    on_way_[static_cast<std::size_t>(j)] = false;
  }
  return 0.5 * (covariance + covariance.transpose());
}

double GraphMarginals::cycle_chi_square(const GraphLink& link) {
  const Matrix6d predicted = relative_covariance(link.from, link.to);
  if (!predicted.allFinite()) return 0;  // nothing to contradict
  const Matrix6d covariance = predicted + link.information.inverse();
  const Vector6d r = residual(world_from_node_, link);
  return r.dot(covariance.ldlt().solve(r));
}

namespace {

// A cycle is tried together with those at most this many times as uncertain as the surest.
constexpr double kAlike = 2.0;

struct Candidate {
  std::size_t link = 0;
  double uncertainty = 0;  // of the cycle, [m^2]
  double chi_square = 0;   // of the cycle
};

std::vector<Candidate> candidates_of(const PoseGraph& graph,
                                     const std::vector<std::size_t>& undecided) {
  GraphMarginals marginals(graph);
  std::vector<Candidate> all;
  for (const std::size_t i : undecided) {
    const GraphLink& link = graph.links[i];
    const Matrix6d covariance =
        marginals.relative_covariance(link.from, link.to) + link.information.inverse();
    all.push_back({.link = i,
                   .uncertainty = covariance.topLeftCorner<3, 3>().trace(),
                   .chi_square = marginals.cycle_chi_square(link)});
  }
  return all;
}

// Switches the worst loop link off, one at a time, until all enabled ones fit. A link that strains
// odometry next to it shows in its own chi-square too: both share the error.
void switch_off_worst(PoseGraph& graph, const GraphOptions& options, GraphSummary& summary) {
  while (true) {
    summary = optimize(graph, options);
    std::size_t worst = graph.links.size();
    double most = options.gate;
    for (std::size_t i = 0; i < graph.links.size(); ++i) {
      const GraphLink& link = graph.links[i];
      if (link.kind != LinkKind::kLoop || !link.enabled) continue;
      const double value = chi_square(graph, link);
      if (value <= most) continue;
      most = value;
      worst = i;
    }
    if (worst == graph.links.size()) return;
    graph.links[worst].enabled = false;
  }
}

GraphSummary select_without_chains(PoseGraph& graph, const GraphOptions& options) {
  std::vector<std::size_t> undecided;
  for (std::size_t i = 0; i < graph.links.size(); ++i) {
    if (graph.links[i].kind != LinkKind::kLoop) continue;
    graph.links[i].enabled = false;
    undecided.push_back(i);
  }
  GraphSummary summary = optimize(graph, options);
  while (!undecided.empty()) {
    const std::vector<Candidate> all = candidates_of(graph, undecided);
    double surest = std::numeric_limits<double>::infinity();
    for (const Candidate& c : all) surest = std::min(surest, c.uncertainty);
    undecided.clear();
    for (const Candidate& c : all) {
      if (c.uncertainty > kAlike * surest)
        undecided.push_back(c.link);
      else
        graph.links[c.link].enabled = c.chi_square <= options.gate;
    }
    switch_off_worst(graph, options, summary);
  }
  // Those refused early may have been refused for the sake of a wrong one.
  std::vector<std::size_t> off;
  for (std::size_t i = 0; i < graph.links.size(); ++i)
    if (!graph.links[i].enabled) off.push_back(i);
  for (const Candidate& c : candidates_of(graph, off))
    graph.links[c.link].enabled = c.chi_square <= options.gate;
  switch_off_worst(graph, options, summary);
  return summary;
}

}  // namespace

GraphSummary select_links(PoseGraph& graph, const GraphOptions& options) {
  if (!all_finite(graph)) return {.status = GraphStatus::kNotFinite};
  GraphChains chains(graph);
  const GraphSummary summary = select_without_chains(chains.reduced(), options);
  chains.restore(graph);
  return summary;
}

}  // namespace edvo
