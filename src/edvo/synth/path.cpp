// SPDX-License-Identifier: MIT
#include "edvo/synth/path.hpp"

#include "edvo/synth/random.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace edvo::synth {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;  // [rad]

double wave(double seconds, double period, double phase) {
  return std::sin(kTurn * seconds / period + phase);
}

// Three independent waves, each a slow one with a faster one on it; within +-1.
Eigen::Vector3d wander(double seconds, double period, Random& random) {
  constexpr double kSlow = 0.8, kFast = 0.2;
  Eigen::Vector3d value;
  for (int axis = 0; axis < 3; ++axis) {
    const double slow = period * random.uniform(0.85, 1.2);
    const double slow_wave = wave(seconds, slow, random.uniform(0, kTurn));
    const double fast_wave = wave(seconds, 0.37 * slow, random.uniform(0, kTurn));
    value[axis] = kSlow * slow_wave + kFast * fast_wave;
  }
  return value;
}

// The tremor of a hand: a millimetre and a tenth of a degree, 3 to 8 Hz.
SE3 tremor(double seconds, Random& random) {
  constexpr double kShift = 0.001, kAngle = 0.0015;  // [m], [rad]
  Vector6d xi;
  for (int i = 0; i < 6; ++i) {  // one draw in a statement: compilers differ in their order
    const double phase = random.uniform(0, kTurn);
    const double rate = random.uniform(3.0, 8.0);
    xi[i] = (i < 3 ? kShift : kAngle) * wave(seconds, 1 / rate, phase);
  }
  return exp(xi);
}

constexpr double kDemoSpeed = 0.55;  // on average [m/s]

SE3 demo(const Path& path, double seconds) {
  constexpr double kTargetWander = 0.15;  // share of the distance to the target
  constexpr double kRoll = 0.06;          // [rad]
  Random random{path.seed, 1};
  const Stage& stage = path.stage;
  constexpr double kLeastReach = 0.05;  // [m]
  const double period =
      4 * std::max(stage.reach.norm(), kLeastReach) / (kDemoSpeed * path.pace);  // [s]
  const Eigen::Vector3d eye = stage.eye + stage.reach.cwiseProduct(wander(seconds, period, random));
  const double distance = (stage.target - stage.eye).norm();
  const Eigen::Vector3d target =
      stage.target + kTargetWander * distance * wander(seconds, 1.3 * period, random);
  Vector6d roll = Vector6d::Zero();
  roll[5] = kRoll * wave(seconds, 0.9 * period, random.uniform(0, kTurn));
  return look_at(eye, target) * exp(roll) * tremor(seconds, random);
}

SE3 orbit(const Path& path, double seconds) {
  constexpr double kPeriod = 8;  // [s]
  const Stage& stage = path.stage;
  const Eigen::Vector3d arm = stage.eye - stage.target;
  const double swing = std::asin(std::min(0.5, stage.reach.x() / arm.head<2>().norm()));
  const Eigen::AngleAxisd turn(swing * wave(seconds, kPeriod, 0), Eigen::Vector3d::UnitZ());
  return look_at(stage.target + turn * arm, stage.target);
}

SE3 pure_rotation(const Path& path, double seconds) {
  constexpr double kRate = 60.0 * std::numbers::pi / 180;  // [rad/s]
  const Eigen::AngleAxisd turn(kRate * seconds, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d forward = path.stage.target - path.stage.eye;
  return look_at(path.stage.eye, path.stage.eye + turn * forward);
}

SE3 xyz(const Path& path, double seconds) {
  constexpr double kSweep = 3;  // there and back along one axis [s]
  Random random{path.seed, 2};
  const auto axis = static_cast<int>(std::fmod(seconds / kSweep, 3));
  // Starts and ends at rest, so that the change of axis is smooth.
  constexpr double kLargest = 0.6496;  // of the product below, at a third of a turn
  const double phase = kTurn * std::fmod(seconds, kSweep) / kSweep;
  const double shift = std::sin(phase) * std::pow(std::sin(phase / 2), 2) / kLargest;
  SE3 pose = look_at(path.stage.eye, path.stage.target);
  pose.translation += shift * path.stage.reach[axis] * Eigen::Vector3d::Unit(axis);
  return pose * tremor(seconds, random);
}

SE3 between(const SE3& a, const SE3& b, double share) {
  return {.rotation = a.rotation.slerp(share, b.rotation),
          .translation = a.translation + share * (b.translation - a.translation)};
}

SE3 recorded_pose(const Trajectory& recorded, double seconds) {
  const auto since_start = [&](const StampedPose& pose) {
    return seconds_between(recorded.front().stamp, pose.stamp);
  };
  const auto after = std::upper_bound(
      recorded.begin(), recorded.end(), seconds,
      [&](double value, const StampedPose& pose) { return value < since_start(pose); });
  if (after == recorded.begin()) return recorded.front().world_from_camera;
  if (after == recorded.end()) return recorded.back().world_from_camera;
  const auto before = std::prev(after);
  const double share =
      (seconds - since_start(*before)) / (since_start(*after) - since_start(*before));
  return between(before->world_from_camera, after->world_from_camera, share);
}

}  // namespace

SE3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - eye).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {.rotation = Eigen::Quaterniond(R).normalized(), .translation = eye};
}

Path make_path(PathName name, const Stage& stage, std::uint64_t seed) {
  Path path{.name = name, .stage = stage, .seed = seed, .recorded = {}};
  if (name != PathName::kDemo) return path;
  // Follow the motion until it has the length that it shall have in that time.
  constexpr double kSpan = 10, kStep = 0.02;  // [s]
  double seconds = 0;
  for (double length = 0; length < kDemoSpeed * kSpan; seconds += kStep)
    length += (demo(path, seconds + kStep).translation - demo(path, seconds).translation).norm();
  path.pace = seconds / kSpan;
  return path;
}

SE3 pose_at(const Path& path, double seconds) {
  if (!path.recorded.empty()) return recorded_pose(path.recorded, seconds);
  switch (path.name) {
    case PathName::kDemo:
      return demo(path, seconds);
    case PathName::kOrbit:
      return orbit(path, seconds);
    case PathName::kPureRotation:
      return pure_rotation(path, seconds);
    case PathName::kStill:
    case PathName::kRounds:
      return look_at(path.stage.eye, path.stage.target);
    case PathName::kXyz:
      return xyz(path, seconds);
  }
  return {};
}

}  // namespace edvo::synth
