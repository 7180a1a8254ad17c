// SPDX-License-Identifier: MIT
// Furnished rooms made of textured boxes, spheres and cylinders. World: z up, floor at z = 0.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/synth/texture.hpp"

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace edvo::synth {

enum class SceneName {
  kDesk,        // a desk with monitors, books and cups, seen from close by
  kOffice,      // desks, shelves, chairs, posters
  kLivingRoom,  // sofa, low table, plants, pictures
  kCorridor,    // long and narrow, doors on both sides
  kWall,        // white walls without any texture: nothing to track
  kBoxes,       // boxes, balls and columns at random
  kFlat,        // six rooms on both sides of a corridor
  kPosters,     // the same, but the rooms differ in one poster each
  kTwins,       // the same, but the rooms are equal
  kDeskRows,    // equal desks 2 m apart on both sides of an aisle
};

struct Material {
  int texture = 0;  // index into Scene::textures
  // BGR [0..255] where the texture is 0 and where it is 1.
  Eigen::Vector3f dark = Eigen::Vector3f::Zero(), bright = Eigen::Vector3f::Zero();
  Eigen::Vector2f tile = {0, 0};  // size of a tile [m]; 0 = once across the face
};

enum class Shape { kBox, kSphere, kCylinder, kRoom };  // a room is a box seen from inside

struct Solid {
  Shape shape = Shape::kBox;
  SE3 world_from_solid;                            // origin in the middle; a cylinder's axis is z
  Eigen::Vector3f half = Eigen::Vector3f::Zero();  // half extents or radii [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // [m/s]; the pose holds at time 0
  double turn_rate = 0;                                // about the vertical at the pivot [rad/s]
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();     // [m]
  std::array<int, 6> materials = {};  // of faces -x +x -y +y -z +z; round ones: of [0]
};

// Where a camera has room to move and something to look at.
struct Stage {
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();     // [m]
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d reach = Eigen::Vector3d::Zero();   // free space around the eye, +- [m]
};

// Way-points on the floor for walks that come back to where they were [m].
struct WalkPlan {
  // Along the corridor, in this order; equal where a scene is not made for walks.
  Eigen::Vector3d south = Eigen::Vector3d::Zero(), home = Eigen::Vector3d::Zero(),
                  north = Eigen::Vector3d::Zero();
  // From the corridor through a room and back, each to be walked in either direction.
  std::vector<std::vector<Eigen::Vector3d>> rounds;
};

struct Scene {
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Solid> solids;                        // the first is the room
  Eigen::Vector3f light = Eigen::Vector3f::Zero();  // a lamp at rest [m]
  float lamp_swing = 0;                             // how far it swings to each side along x [m]
  bool shadows = false;                             // solids keep its light from each other
  Stage stage;
  WalkPlan walk;
};

// The same name and seed give the same scene.
[[nodiscard]] Scene make_scene(SceneName name, std::uint64_t seed);

// Where a solid is at a time [s].
[[nodiscard]] inline SE3 pose_at(const Solid& solid, double seconds) {
  SE3 pose = solid.world_from_solid;
  if (solid.turn_rate != 0) {
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(seconds * solid.turn_rate, Eigen::Vector3d::UnitZ()));
    pose.rotation = turn * pose.rotation;
    pose.translation = solid.pivot + turn * (pose.translation - solid.pivot);
  }
  pose.translation += seconds * solid.velocity;
  return pose;
}

// Where the lamp is at a time [s].
[[nodiscard]] Eigen::Vector3f lamp_at(const Scene& scene, double seconds);

// Distance from a point [m] to the nearest surface at time 0 [m]; negative outside the room or in a
// solid.
[[nodiscard]] double clearance(const Scene& scene, const Eigen::Vector3d& point);

}  // namespace edvo::synth

template <>
struct edvo::EnumNames<edvo::synth::SceneName> {
  using SceneName = edvo::synth::SceneName;
  static constexpr auto names = std::to_array<std::pair<SceneName, std::string_view>>({
      {SceneName::kDesk, "desk"},
      {SceneName::kOffice, "office"},
      {SceneName::kLivingRoom, "living_room"},
      {SceneName::kCorridor, "corridor"},
      {SceneName::kWall, "wall"},
      {SceneName::kBoxes, "boxes"},
      {SceneName::kFlat, "flat"},
      {SceneName::kPosters, "posters"},
      {SceneName::kTwins, "twins"},
      {SceneName::kDeskRows, "desk_rows"},
  });
};
