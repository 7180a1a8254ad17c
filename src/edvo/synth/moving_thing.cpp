// SPDX-License-Identifier: MIT
#include "edvo/synth/moving_thing.hpp"

#include "edvo/synth/furniture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace edvo::synth {
namespace {

constexpr double kBoxDistance = 0.9;                    // [m]
constexpr double kBoxSpeed = 0.8;                       // [m/s]
constexpr double kNearestPerson = 0.6;                  // [m]
constexpr double kWalkingSpeed = 1.2;                   // [m/s]
constexpr double kNearestEdge = 0.6;                    // of a turntable's column [m]
constexpr double kTurningSpeed = std::numbers::pi / 4;  // [rad/s]

// Of the image at a distance of 1 m [m].
Eigen::Vector2d image_size(const Camera& camera) {
  return {camera.width / camera.fx, camera.height / std::abs(camera.fy)};
}

// Width and height of a share of the image: square, or as high as the image.
Eigen::Vector2d rectangle(const Camera& camera, double share) {
  const Eigen::Vector2d image = image_size(camera);
  const double area = share * image.prod();
  const double height = std::min(std::sqrt(area), image.y());
  return {area / height, height};
}

// The horizontal direction closest to one that is not vertical.
Eigen::Vector3d level(const Eigen::Vector3d& direction) {
  return Eigen::Vector3d{direction.x(), direction.y(), 0}.normalized();
}

void add_crossing_box(Builder& builder, double share, const Encounter& at) {
  const int cover = add_material(builder, Pattern::kPoster, {40, 60, 90}, {150, 200, 235});
  const Eigen::Vector2d front = kBoxDistance * rectangle(at.camera, share);  // [m]
  add_box(builder, {}, {front.x(), front.y(), front.y()}, cover);
  Solid& box = builder.scene.solids.back();
  box.world_from_solid = at.world_from_camera;
  box.velocity = kBoxSpeed * (at.world_from_camera.rotation * Eigen::Vector3d::UnitX());
  box.world_from_solid.translation =
      at.world_from_camera * Eigen::Vector3d{0, 0, kBoxDistance + front.y() / 2} -
      at.seconds * box.velocity;
}

// As of a place on the floor: legs, trunk, arms, head.
void add_body(Builder& builder, const Place& place) {
  const int trousers = add_material(builder, Pattern::kFabric, {50, 35, 30}, {120, 90, 75}, 0.3);
  const int shirt = add_material(builder, Pattern::kStripes, {30, 40, 110}, {190, 200, 225}, 0.25);
  const int skin = add_material(builder, Pattern::kPlaster, {120, 150, 190}, {150, 180, 220}, 0.3);
  const int hair = add_material(builder, Pattern::kSpeckle, {10, 15, 20}, {50, 60, 75}, 0.15);
  for (const double side : {-1.0, 1.0}) {
    add_cylinder(builder, beside(place, {0.1 * side, 0, 0}), 0.08, 0.85, trousers);
    add_cylinder(builder, beside(place, {0.25 * side, 0, 0.75}), 0.05, 0.65, shirt);
    add_sphere(builder, beside(place, {0.25 * side, 0, 0.72}).base, 0.055, skin);
  }
  add_box(builder, beside(place, {0, 0, 0.82}), {0.4, 0.22, 0.6}, shirt);
  add_cylinder(builder, beside(place, {0, 0, 1.4}), 0.06, 0.1, skin);
  add_sphere(builder, beside(place, {0, 0, 1.58}).base, 0.115, skin);
  add_sphere(builder, beside(place, {0, 0.03, 1.62}).base, 0.115, hair);
}

void add_walking_person(Builder& builder, double share, const Encounter& at) {
  constexpr double kWidth = 0.45;  // of the body, arms included, on average over its height [m]
  const double distance = std::max(kNearestPerson, kWidth / (share * image_size(at.camera).x()));
  const Eigen::Quaterniond& rotation = at.world_from_camera.rotation;
  const Eigen::Vector3d right = level(rotation * Eigen::Vector3d::UnitX());
  const Eigen::Vector3d velocity = kWalkingSpeed * right;
  const std::size_t first = builder.scene.solids.size();
  Place place{.base = at.world_from_camera.translation +
                      distance * level(rotation * Eigen::Vector3d::UnitZ()),
              .yaw = std::atan2(right.y(), right.x())};
  place.base.z() = 0;
  place.base -= at.seconds * velocity;
  add_body(builder, place);
  for (std::size_t i = first; i < builder.scene.solids.size(); ++i)
    builder.scene.solids[i].velocity = velocity;
}

// A column higher than the image, so that its share is that of its width: exact where a side faces
// the camera. Its edges come as near as kNearestEdge.
void add_turntable(Builder& builder, double share, const Encounter& at) {
  constexpr double kHalfDiagonal = 0.5 * std::numbers::sqrt2;
  const Eigen::Vector2d image = image_size(at.camera);
  const double width = share * image.x();
  const double side = kNearestEdge * width / (1 - (kHalfDiagonal - 0.5) * width);  // [m]
  const double axis = kNearestEdge + kHalfDiagonal * side;                         // [m]
  const double height = 1.2 * axis * image.y();                                    // [m]
  constexpr double kDisc = 0.03;                                                   // [m]
  const int wood = add_material(builder, Pattern::kWood, {30, 55, 90}, {120, 175, 220}, 0.5);
  const int poster = add_material(builder, Pattern::kPoster, {50, 30, 20}, {235, 215, 190});
  const int book = add_material(builder, Pattern::kBook, {30, 30, 90}, {170, 200, 230});
  const std::size_t first = builder.scene.solids.size();
  Place place{.base = at.world_from_camera * Eigen::Vector3d{0, 0, axis}};
  place.base.z() -= height / 2;
  add_cylinder(builder, beside(place, {0, 0, -kDisc}), 0.9 * side, kDisc, wood);
  add_box(builder, place, {side, side, height}, poster);
  add_box(builder, beside(place, {0.65 * side, 0, 0}), {0.2 * side, 0.3 * side, 0.6 * height},
          book);
  add_box(builder, beside(place, {0, 0.65 * side, 0}), {0.3 * side, 0.2 * side, 0.45 * height},
          book);
  for (std::size_t i = first; i < builder.scene.solids.size(); ++i) {
    builder.scene.solids[i].turn_rate = kTurningSpeed;
    builder.scene.solids[i].pivot = place.base;
  }
}

}  // namespace

void add_moving_thing(Scene& scene, MovingThing thing, double share, const Encounter& encounter,
                      std::uint64_t seed) {
  Builder builder{.scene = std::move(scene), .random = Random{seed, 4}, .painted = {}};
  switch (thing) {
    case MovingThing::kNone:
      break;
    case MovingThing::kBox:
      add_crossing_box(builder, share, encounter);
      break;
    case MovingThing::kPerson:
      add_walking_person(builder, share, encounter);
      break;
    case MovingThing::kTurntable:
      add_turntable(builder, share, encounter);
      break;
  }
  scene = std::move(builder.scene);
}

}  // namespace edvo::synth
