// SPDX-License-Identifier: MIT
// What the back end costs by the number of keyframes: the pose graph of a walk in laps with right
// and wrong links, and the search for places among random codes.
//
// back_end_growth [KEYFRAMES...]
#include "edvo/core/random.hpp"
#include "edvo/report/machine.hpp"
#include "edvo/slam/place_index.hpp"
#include "edvo/slam/pose_graph.hpp"
#include "measure.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

namespace {

using namespace edvo;
using benchmarks::cpu_seconds;

constexpr int kPlaces = 300, kLaps = 15;             // as many places as Slam keeps
constexpr double kStepSigma = 1e-3;                  // [m], [rad]
constexpr double kLinkSigma = 5e-3;                  // [m], [rad]
constexpr int kRightLinks = 480, kWrongLinks = 120;  // Slam aligns 240 by looks, then by pose

Vector6d noise(Random& random, double sigma) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = sigma * static_cast<double>(random.normal());
  return xi;
}

SE3 true_pose(int i, int keyframes) {
  const double angle = 2 * std::numbers::pi * i / (keyframes / kLaps);
  Vector6d turn = Vector6d::Zero();
  turn[5] = angle;
  return {.rotation = exp(turn).rotation,
          .translation = {10 * std::sin(angle), -10 * std::cos(angle), 1e-5 * i}};
}

PoseGraph walk(const std::vector<SE3>& truth, Random& random) {
  const auto pose = [&](int i) { return truth[static_cast<std::size_t>(i)]; };
  PoseGraph graph{.world_from_node = {truth.front()}};
  const auto measure = [&](int from, int to, double sigma, LinkKind kind) {
    graph.links.push_back(
        {.from = from,
         .to = to,
         .from_pose_to = inverse(pose(from)) * pose(to) * exp(noise(random, sigma)),
         .information = Matrix6d::Identity() / (sigma * sigma),
         .kind = kind});
  };
  const int keyframes = static_cast<int>(truth.size());
  for (int i = 0; i + 1 < keyframes; ++i) {
    measure(i, i + 1, kStepSigma, LinkKind::kOdometry);
    graph.world_from_node.push_back(graph.world_from_node.back() * graph.links.back().from_pose_to);
  }
  const int lap = keyframes / kLaps, apart = keyframes / kPlaces;
  for (int k = 0; k < kRightLinks + kWrongLinks; ++k) {
    const int place = apart * random.below(lap / apart);
    const int to = 1 + random.below(kLaps - 1), from = random.below(to);
    measure(place + lap * from, place + lap * to, kLinkSigma, LinkKind::kLoop);
    if (k < kRightLinks) continue;
    Vector6d wrong = noise(random, 0.5);
    wrong[k % 3] += 0.5;
    graph.links.back().from_pose_to = graph.links.back().from_pose_to * exp(wrong);
  }
  return graph;
}

double rms_error(const PoseGraph& graph, const std::vector<SE3>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    sum += (graph.world_from_node[i].translation - truth[i].translation).squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

// Mean of one search [ms].
double search_milliseconds(int keyframes, Random& random) {
  constexpr int kSearches = 50;
  PlaceIndex index;
  FernCode code{};
  for (int i = 0; i < keyframes; ++i) {
    for (std::uint8_t& byte : code) byte = static_cast<std::uint8_t>(random.below(256));
    index.add(i, code);
  }
  const double begin = cpu_seconds();
  for (int i = 0; i < kSearches; ++i) benchmarks::keep(index.search(code, keyframes, 60));
  return 1e3 * (cpu_seconds() - begin) / kSearches;
}

void measure(int keyframes) {
  Random random{1};
  std::vector<SE3> truth;
  for (int i = 0; i < keyframes; ++i) truth.push_back(true_pose(i, keyframes));
  PoseGraph graph = walk(truth, random);
  const double drift = rms_error(graph, truth);
  const double begin = cpu_seconds();
  select_links(graph);
  const double seconds = cpu_seconds() - begin;
  int right = 0, wrong = 0;
  const std::size_t loops = graph.links.size() - kRightLinks - kWrongLinks;
  for (std::size_t i = loops; i < graph.links.size(); ++i)
    (i < loops + kRightLinks ? right : wrong) += graph.links[i].enabled ? 1 : 0;
  fmt::print("{:9} {:9.2f} {:8} {:8} {:10.3f} {:9.3f} {:10.2f} {:7.0f}\n", keyframes, seconds,
             right, wrong, drift, rms_error(graph, truth), search_milliseconds(keyframes, random),
             peak_memory());
}

}  // namespace

int main(int argc, char** argv) {
  fmt::print("keyframes graph [s] right of wrong of  drift [m]  then [m] search [ms]    [MB]\n");
  fmt::print("{:19} {:8} {:8}\n", "", kRightLinks, kWrongLinks);
  if (argc < 2)
    for (const int keyframes : {1000, 10000, 100000}) measure(keyframes);
  for (int i = 1; i < argc; ++i) measure(std::max(kPlaces, std::atoi(argv[i])));
}
