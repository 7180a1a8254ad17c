// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/synth/path.hpp"
#include "edvo/synth/rays.hpp"

#include <algorithm>
#include <numbers>
#include <optional>

namespace edvo::synth {
namespace {

constexpr double kSafeDistance = 0.3;                    // between camera and surfaces [m]
constexpr double kNearestView = 0.5, kFarthestView = 4;  // [m]

// How a recorded motion is stood into a room: x_room = room_from_motion * (scale * x_motion).
struct Placement {
  SE3 room_from_motion;
  double scale = 1;
};

SE3 place(const Placement& placement, const SE3& pose) {
  return placement.room_from_motion *
         SE3{.rotation = pose.rotation, .translation = placement.scale * pose.translation};
}

// Enough poses to judge by.
std::vector<SE3> thinned(const Trajectory& recorded) {
  constexpr std::size_t kEnough = 150;
  const std::size_t step = std::max<std::size_t>(1, recorded.size() / kEnough);
  std::vector<SE3> poses;
  for (std::size_t i = 0; i < recorded.size(); i += step)
    poses.push_back(recorded[i].world_from_camera);
  return poses;
}

// The rotation that makes the camera upright on average, if the world is not z up already.
Eigen::Quaterniond upright(const std::vector<SE3>& poses) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const SE3& pose : poses) up -= pose.rotation * Eigen::Vector3d::UnitY();
  up /= static_cast<double>(poses.size());
  constexpr double kUpright = 0.4;  // cosine; cameras look up and down a lot
  if (up.z() > kUpright || up.norm() < kUpright) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

// Share of poses whose optical axis ends at a useful distance.
double share_of_good_views(const Scene& scene, const std::vector<SE3>& poses,
                           const Placement& placement) {
  constexpr std::size_t kStep = 4;  // casting is slow
  int good = 0, all = 0;
  for (std::size_t i = 0; i < poses.size(); i += kStep, ++all) {
    const std::vector<SolidInView> solids = view_from(scene, 0, place(placement, poses[i]));
    const Hit hit = cast(solids, nearest_first(solids), RayPack{})[0];
    if (hit.depth >= kNearestView && hit.depth <= kFarthestView) ++good;
  }
  return static_cast<double>(good) / all;
}

double least_clearance(const Scene& scene, const std::vector<SE3>& poses,
                       const Placement& placement) {
  double least = std::numeric_limits<double>::infinity();
  for (const SE3& pose : poses) {
    least = std::min(least, clearance(scene, place(placement, pose).translation));
    if (least < kSafeDistance) break;
  }
  return least;
}

// The best of a grid of turns and shifts, if any keeps clear of the furniture.
std::optional<Placement> best_placement(const Scene& scene, const std::vector<SE3>& poses,
                                        double scale) {
  constexpr int kTurns = 12;
  const Eigen::Quaterniond level = upright(poses);
  Eigen::AlignedBox3d extent;
  for (const SE3& pose : poses) extent.extend(scale * (level * pose.translation));
  const Eigen::Vector3d room = scene.solids.front().half.cast<double>();
  const Eigen::Vector3d middle = scene.solids.front().world_from_solid.translation;
  std::optional<Placement> best;
  double best_score = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Eigen::Quaterniond yaw(
        Eigen::AngleAxisd(2 * std::numbers::pi * turn / kTurns, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector3d centre = yaw * extent.center();
    for (const double sx : {-0.4, -0.2, 0.0, 0.2, 0.4})
      for (const double sy : {-0.4, -0.2, 0.0, 0.2, 0.4})
        for (const double height : {extent.center().z(), scene.stage.eye.z()}) {
          const Eigen::Vector3d to{middle.x() + sx * room.x(), middle.y() + sy * room.y(), height};
          const Placement placement{
              .room_from_motion = {.rotation = yaw * level, .translation = to - centre},
              .scale = scale};
          const double clear = least_clearance(scene, poses, placement);
          if (clear < kSafeDistance) continue;
          const double score =
              share_of_good_views(scene, poses, placement) + 0.1 * std::min(clear, 1.0);
          if (score > best_score) {
            best_score = score;
            best = placement;
          }
        }
  }
  return best;
}

}  // namespace

Trajectory fit_into(const Scene& scene, const Trajectory& recorded) {
  if (recorded.size() < 2)
    throw Error(ErrorCode::kInput, "trajectory: at least two poses are needed for a path, got " +
                                       std::to_string(recorded.size()));
  const std::vector<SE3> poses = thinned(recorded);
  constexpr double kShrink = 0.85;
  constexpr double kSmallest = 0.05;
  for (double scale = 1; scale > kSmallest; scale *= kShrink)
    if (const auto placement = best_placement(scene, poses, scale)) {
      Trajectory fitted = recorded;
      for (StampedPose& pose : fitted)
        pose.world_from_camera = place(*placement, pose.world_from_camera);
      return fitted;
    }
  throw Error(ErrorCode::kInput,
              "trajectory: no way to fit it into the scene without running into something; try "
              "another scene");
}

}  // namespace edvo::synth
