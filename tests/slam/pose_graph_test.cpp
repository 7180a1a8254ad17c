// SPDX-License-Identifier: MIT
#include "edvo/slam/pose_graph.hpp"

#include "edvo/core/random.hpp"
#include "edvo/slam/graph_chains.hpp"
#include "support/matchers.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <numbers>

namespace edvo {
namespace {

using test::NearPose;

constexpr int kLap = 50;              // nodes
constexpr double kStep = 0.1;         // [m] between nodes
constexpr double kOdometrySigma = 1;  // [mm], [mrad] of each step
constexpr double kLoopSigma = 3;      // [mm], [mrad]

Vector6d noise(Random& random, double sigma) {  // [mm], [mrad]
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = 1e-3 * sigma * static_cast<double>(random.normal());
  return xi;
}

Matrix6d information_of(double sigma) {  // [mm], [mrad]
  return Matrix6d::Identity() / (1e-6 * sigma * sigma);
}

// Laps on a circle that rises a little, looking ahead.
std::vector<SE3> circle(int nodes) {
  const double radius = kStep * kLap / (2 * std::numbers::pi);
  std::vector<SE3> poses;
  for (int i = 0; i < nodes; ++i) {
    const double angle = 2 * std::numbers::pi * i / kLap;
    Vector6d turn;
    turn << 0, 0, 0, 0, 0, angle;
    poses.push_back(
        {.rotation = exp(turn).rotation,
         .translation = {radius * std::sin(angle), -radius * std::cos(angle), 1e-4 * i}});
  }
  return poses;
}

GraphLink measure(const std::vector<SE3>& truth, int from, int to, double sigma, LinkKind kind,
                  Random& random) {
  const SE3 exact =
      inverse(truth[static_cast<std::size_t>(from)]) * truth[static_cast<std::size_t>(to)];
  return {.from = from,
          .to = to,
          .from_pose_to = exact * exp(noise(random, sigma)),
          .information = information_of(sigma),
          .kind = kind};
}

// Odometry with noise; no loops yet.
PoseGraph drifting(const std::vector<SE3>& truth, Random& random) {
  PoseGraph graph{.world_from_node = {truth.front()}};
  for (int i = 0; i + 1 < static_cast<int>(truth.size()); ++i) {
    graph.links.push_back(measure(truth, i, i + 1, kOdometrySigma, LinkKind::kOdometry, random));
    graph.world_from_node.push_back(graph.world_from_node.back() * graph.links.back().from_pose_to);
  }
  return graph;
}

void add_right_loops(PoseGraph& graph, const std::vector<SE3>& truth, int every, Random& random) {
  for (int i = kLap; i < static_cast<int>(truth.size()); i += every)
    graph.links.push_back(measure(truth, i - kLap, i, kLoopSigma, LinkKind::kLoop, random));
}

// Between any two nodes, off by half a metre to metres: another place that looks alike.
void add_wrong_loops(PoseGraph& graph, const std::vector<SE3>& truth, int count, Random& random) {
  const int nodes = static_cast<int>(truth.size());
  for (int k = 0; k < count; ++k) {
    const int from = random.below(nodes - 2 * kLap);
    const int to = from + kLap + random.below(nodes - kLap - from);
    GraphLink link = measure(truth, from, to, kLoopSigma, LinkKind::kLoop, random);
    Vector6d offset = noise(random, 500);
    offset[k % 3] += 0.5;
    link.from_pose_to = link.from_pose_to * exp(offset);
    graph.links.push_back(link);
  }
}

double rms_error(const PoseGraph& graph, const std::vector<SE3>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    sum += (graph.world_from_node[i].translation - truth[i].translation).squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

TEST(PoseGraph, ExactLinksRestoreDisturbedPoses) {
  Random random{1};
  const std::vector<SE3> truth = circle(120);
  PoseGraph graph{.world_from_node = truth};
  for (int i = 0; i + 1 < 120; ++i)
    graph.links.push_back(measure(truth, i, i + 1, 0, LinkKind::kOdometry, random));
  for (GraphLink& link : graph.links) link.information = information_of(1);
  for (std::size_t i = 1; i < truth.size(); ++i)
    graph.world_from_node[i] = truth[i] * exp(noise(random, 100));
  const GraphSummary summary = optimize(graph);
  EXPECT_EQ(summary.status, GraphStatus::kConverged);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_THAT(graph.world_from_node[i], NearPose(truth[i], 1e-6)) << i;
}

TEST(PoseGraph, LoopsLowerTheDriftAndTheFirstNodeStays) {
  Random random{2};
  const std::vector<SE3> truth = circle(6 * kLap);
  PoseGraph graph = drifting(truth, random);
  const double before = rms_error(graph, truth);
  add_right_loops(graph, truth, 5, random);
  const GraphSummary summary = optimize(graph);
  EXPECT_EQ(summary.status, GraphStatus::kConverged);
  EXPECT_LT(summary.cost, summary.initial_cost);
  EXPECT_LT(rms_error(graph, truth), 0.5 * before);
  EXPECT_THAT(graph.world_from_node.front(), NearPose(truth.front(), 1e-15));
}

// At the optimum the chi-squares of all links sum to the redundant measurements, on average.
TEST(PoseGraph, CostAtTheOptimumIsThatOfTheNoise) {
  Random random{3};
  const std::vector<SE3> truth = circle(10 * kLap);
  PoseGraph graph = drifting(truth, random);
  add_right_loops(graph, truth, 2, random);
  const GraphSummary summary = optimize(graph);
  const double redundant = 6.0 * static_cast<double>(graph.links.size() + 1 - truth.size());
  EXPECT_NEAR(2 * summary.cost / redundant, 1.0, 0.1);
}

TEST(PoseGraph, SameBitsFromRunToRun) {
  const auto run = [] {
    Random random{4};
    const std::vector<SE3> truth = circle(4 * kLap);
    PoseGraph graph = drifting(truth, random);
    add_right_loops(graph, truth, 3, random);
    add_wrong_loops(graph, truth, 10, random);
    select_links(graph);
    return graph;
  };
  const PoseGraph a = run(), b = run();
  for (std::size_t i = 0; i < a.world_from_node.size(); ++i) {
    EXPECT_EQ(a.world_from_node[i].translation, b.world_from_node[i].translation);
    EXPECT_EQ(a.world_from_node[i].rotation.coeffs(), b.world_from_node[i].rotation.coeffs());
  }
}

TEST(PoseGraph, RefusesWhatIsNotFiniteAndLeavesThePoses) {
  Random random{5};
  const std::vector<SE3> truth = circle(20);
  PoseGraph graph = drifting(truth, random);
  graph.links[3].information(2, 2) = std::numeric_limits<double>::quiet_NaN();
  const PoseGraph before = graph;
  EXPECT_EQ(optimize(graph).status, GraphStatus::kNotFinite);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_EQ(graph.world_from_node[i].translation, before.world_from_node[i].translation);
}

TEST(PoseGraph, EachPartIsHeldByItsFirstNode) {
  Random random{6};
  const std::vector<SE3> truth = circle(40);
  PoseGraph graph = drifting(truth, random);
  graph.links.erase(graph.links.begin() + 19);  // nodes 0..19 and 20..39
  const SE3 second = graph.world_from_node[20];
  graph.world_from_node[30] = graph.world_from_node[30] * exp(noise(random, 50));
  EXPECT_EQ(optimize(graph).status, GraphStatus::kConverged);
  EXPECT_THAT(graph.world_from_node[20], NearPose(second, 1e-15));
  EXPECT_FALSE(GraphMarginals(graph).relative_covariance(5, 25).allFinite());
}

// Twenty steps along a chain have twenty times the variance in the direction ahead.
TEST(PoseGraph, MarginalsOfAChainAddUp) {
  std::vector<SE3> line(30);
  for (int i = 0; i < 30; ++i) line[static_cast<std::size_t>(i)].translation = {0.1 * i, 0, 0};
  Random random{7};
  PoseGraph graph = drifting(line, random);
  const Matrix6d covariance = GraphMarginals(graph).relative_covariance(4, 24);
  EXPECT_NEAR(covariance(0, 0), 20e-6, 1e-8);
  EXPECT_NEAR(covariance(3, 3), 20e-6, 1e-8);
  EXPECT_GT(covariance(1, 1), 20e-6);  // turns add to what lies across
}

// A right link's cycle has a chi-square of six degrees of freedom: mean 6, variance 12.
TEST(PoseGraph, CycleOfARightLinkHasItsChiSquare) {
  double sum = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    Random random{8, static_cast<std::uint64_t>(trial)};
    const std::vector<SE3> truth = circle(kLap + 10);
    const PoseGraph graph = drifting(truth, random);
    const GraphLink link = measure(truth, 3, kLap + 3, kLoopSigma, LinkKind::kLoop, random);
    sum += GraphMarginals(graph).cycle_chi_square(link);
  }
  EXPECT_NEAR(sum / kTrials, 6.0, 4 * std::sqrt(12.0 / kTrials));
}

class WrongLinks : public ::testing::TestWithParam<int> {};

TEST_P(WrongLinks, AreAllSwitchedOffAndTheRightOnesStay) {
  const int percent = GetParam();
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    Random random{9, seed};
    const std::vector<SE3> truth = circle(8 * kLap);
    PoseGraph graph = drifting(truth, random);
    add_right_loops(graph, truth, 4, random);
    const std::size_t first_wrong = graph.links.size();
    const auto right = static_cast<int>(first_wrong - truth.size() + 1);
    const int wrong = std::max(1, static_cast<int>(right * percent / (100.0 - percent)));
    add_wrong_loops(graph, truth, wrong, random);
    EXPECT_NE(select_links(graph).status, GraphStatus::kNotFinite);
    int kept = 0;
    for (std::size_t i = truth.size() - 1; i < graph.links.size(); ++i) {
      if (i >= first_wrong) {
        EXPECT_FALSE(graph.links[i].enabled) << percent << " %, link " << i;
      }
      if (i < first_wrong && graph.links[i].enabled) ++kept;
    }
    EXPECT_GE(kept, right * 97 / 100) << percent << " %";
  }
}

INSTANTIATE_TEST_SUITE_P(Percent, WrongLinks, ::testing::Values(1, 5, 10, 20, 30, 40, 50));

// The nodes that no loop touches come out as if all had been optimized together.
TEST(PoseGraph, ChainsOfOdometryAreLeftOutWithoutLoss) {
  Random random{11};
  const std::vector<SE3> truth = circle(8 * kLap);
  PoseGraph graph = drifting(truth, random);
  add_right_loops(graph, truth, 20, random);
  for (GraphLink& link : graph.links)  // some steps measured the other way round
    if (link.kind == LinkKind::kOdometry && link.from % 3 == 0) {
      std::swap(link.from, link.to);
      const Matrix6d turned = adjoint(inverse(link.from_pose_to));
      link.information = turned.transpose().inverse() * link.information * turned.inverse();
      link.from_pose_to = inverse(link.from_pose_to);
    }
  PoseGraph reduced = graph;
  optimize(graph);
  select_links(reduced);
  EXPECT_LT(GraphChains(reduced).reduced().world_from_node.size(), truth.size() / 4);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_THAT(reduced.world_from_node[i], NearPose(graph.world_from_node[i], 1e-4)) << i;
  for (const GraphLink& link : reduced.links) EXPECT_TRUE(link.enabled);
}

}  // namespace
}  // namespace edvo
