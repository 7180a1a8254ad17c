// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/synth/path.hpp"
#include "edvo/synth/random.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace edvo::synth {
namespace {

using WayPoints = std::vector<Eigen::Vector3d>;  // on the floor [m]

constexpr double kTurn = 2 * std::numbers::pi;  // [rad]
constexpr double kPeriod = 0.02;                // of a walk's poses [s]

double length_of(std::span<const Eigen::Vector3d> points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

// Rounds through rooms at random as long as there is length for one more, then to and fro between
// the ends, and home; longer than asked where even the way home is.
WayPoints tour(const WalkPlan& plan, double length, std::uint64_t seed) {
  Random random{seed, 6};
  WayPoints points = {plan.home};
  const auto rest = [&](const Eigen::Vector3d& from) {  // left after the shortest way home
    return length - length_of(points) - (plan.south - from).norm() -
           (plan.home - plan.south).norm();
  };
  const auto rooms = static_cast<int>(plan.rounds.size());
  for (int last = -1; rooms > 1;) {
    int room = last;
    while (room == last) room = random.below(rooms);
    last = room;
    WayPoints round = plan.rounds[static_cast<std::size_t>(room)];
    if (random.below(2) == 1) std::reverse(round.begin(), round.end());
    const double extra = (round.front() - points.back()).norm() + length_of(round);
    if (rest(round.back()) < extra) break;
    points.insert(points.end(), round.begin(), round.end());
  }
  for (double left = rest(points.back()); left > 0;) {
    const double there = std::min(left / 2, (plan.north - points.back()).norm());
    const Eigen::Vector3d along = (plan.north - plan.south).normalized();
    points.push_back(points.back() + there * along);
    left -= 2 * there;
    if (left > 0) points.push_back(plan.south);
  }
  points.push_back(plan.south);
  points.push_back(plan.home);
  return points;
}

// What the walker heads for: a point that runs along the way-points ahead of it.
class Carrot {
 public:
  explicit Carrot(WayPoints points) : points_(std::move(points)), at_(points_.front()) {}

  // Runs on until it is that far away, or at the end.
  void run_from(const Eigen::Vector3d& walker, double distance) {
    constexpr double kStep = 0.01;  // [m]
    while (!is_at_end() && (at_ - walker).norm() < distance) {
      const Eigen::Vector3d left = points_[next_] - at_;
      if (left.norm() <= kStep)
        at_ = points_[next_++];
      else
        at_ += kStep * left.normalized();
    }
  }

  [[nodiscard]] bool is_at_end() const { return next_ == points_.size(); }
  [[nodiscard]] const Eigen::Vector3d& at() const { return at_; }

 private:
  WayPoints points_;
  Eigen::Vector3d at_;
  std::size_t next_ = 1;
};

// A head on a walking body: it looks around a little, and each step shakes it.
SE3 camera_of(const Eigen::Vector3d& feet, double yaw, double seconds) {
  constexpr double kEye = 1.3, kBob = 0.012;                   // [m]
  constexpr double kSteps = 1.8;                               // [1/s]
  constexpr double kPitch = 0.12, kNod = 0.006, kRoll = 0.01;  // [rad]
  constexpr double kGlance = 0.12, kGlances = 7;               // [rad], [s]
  const double step = kTurn * kSteps * seconds;
  const double pitch = kPitch + kNod * std::sin(step + 1);
  const double heading = yaw + kGlance * std::sin(kTurn * seconds / kGlances);
  const Eigen::Vector3d eye = feet + Eigen::Vector3d{0, 0, kEye + kBob * std::sin(step)};
  const Eigen::Vector3d forward{std::cos(heading) * std::cos(pitch),
                                std::sin(heading) * std::cos(pitch), -std::sin(pitch)};
  Vector6d roll = Vector6d::Zero();
  roll[5] = kRoll * std::sin(step / 2);
  return look_at(eye, eye + forward) * exp(roll);
}

// Pure pursuit, slower where it turns: around corners in arcs, about on the spot.
Trajectory follow(const WayPoints& points) {
  constexpr double kAhead = 0.5;                     // [m]
  constexpr double kSpeed = 0.9, kSlowest = 0.05;    // [m/s]
  constexpr double kFastestTurn = 0.9, kGain = 2.5;  // [rad/s], [1/s]
  constexpr double kInertia = 0.2;                   // [s]
  Carrot carrot(points);
  Eigen::Vector3d feet = points.front();
  double yaw = std::numbers::pi / 2, speed = 0, turning = 0;  // along y at first
  Trajectory walk;
  for (std::int64_t i = 0;; ++i) {
    const double seconds = static_cast<double>(i) * kPeriod;
    walk.push_back(
        {.stamp = stamp_from_seconds(seconds), .world_from_camera = camera_of(feet, yaw, seconds)});
    carrot.run_from(feet, kAhead);
    const Eigen::Vector3d to = carrot.at() - feet;
    const Eigen::Vector3d heading{std::cos(yaw), std::sin(yaw), 0};
    if (carrot.is_at_end() && to.dot(heading) < kSlowest) return walk;
    const double off = std::remainder(std::atan2(to.y(), to.x()) - yaw, kTurn);
    const double wanted = kSpeed * std::clamp(std::cos(off), 0.0, to.norm() / kAhead);
    speed += (std::max(wanted, kSlowest) - speed) * kPeriod / kInertia;
    turning +=
        (std::clamp(kGain * off, -kFastestTurn, kFastestTurn) - turning) * kPeriod / kInertia;
    yaw += turning * kPeriod;
    feet += speed * kPeriod * heading;
  }
}

}  // namespace

Trajectory make_rounds(const Scene& scene, double length, std::uint64_t seed) {
  if (scene.walk.home == scene.walk.north)
    throw Error(ErrorCode::kConfig,
                "path rounds: this scene is one room; take flat, twins, posters or desk_rows");
  constexpr int kCorrections = 4;  // corners are cut, so way-points are longer than the walk
  double aim = length;
  Trajectory walk = follow(tour(scene.walk, aim, seed));
  for (int i = 0; i < kCorrections; ++i) {
    aim += length - path_length(walk);
    walk = follow(tour(scene.walk, aim, seed));
  }
  return walk;
}

}  // namespace edvo::synth
