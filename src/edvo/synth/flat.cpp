// SPDX-License-Identifier: MIT
#include "edvo/synth/flat.hpp"

#include <algorithm>
#include <numbers>

namespace edvo::synth {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;  // [rad]

// A room's frame: its middle on the floor; -y leads through the door into the corridor.
constexpr int kBays = 3;                      // rooms on each side
constexpr double kWidth = 4.6, kDepth = 4.8;  // of a room, along the corridor and away from it [m]
constexpr double kHeight = 2.6;               // [m]
constexpr double kPartition = 0.05;           // half of a wall between two rooms [m]
constexpr double kFront = 0.1;                // a wall to the corridor [m]
constexpr double kSlab = 0.01;                // of floors and ceilings [m]
constexpr double kHalfAisle = 1.0;            // half the corridor's width [m]
constexpr double kDoor = -1.1;                // x of the door's middle [m]
constexpr double kDoorWidth = 1.0, kDoorHeight = 2.05;
constexpr double kPitch = kWidth + 2 * kPartition;          // [m]
constexpr double kAway = kHalfAisle + kFront + kDepth / 2;  // from the corridor's middle [m]
constexpr double kHalfLength = kBays * kPitch / 2;          // of the corridor [m]

const Eigen::Vector3f kFarAbove{0, 0, 1000};  // [m] a lamp that leaves the same light everywhere

SE3 pose_of(const Place& place) {
  return {.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(place.yaw, Eigen::Vector3d::UnitZ())),
          .translation = place.base};
}

// Solids that were made about the origin.
using Solids = std::vector<Solid>;

template <typename Furnish>
Solids made_by(Builder& builder, const Furnish& furnish) {
  Solids outside = std::move(builder.scene.solids);
  builder.scene.solids.clear();
  furnish();
  std::swap(outside, builder.scene.solids);
  return outside;
}

void stand(Builder& builder, Solids solids, const Place& place) {
  for (Solid& solid : solids) {
    solid.world_from_solid = pose_of(place) * solid.world_from_solid;
    builder.scene.solids.push_back(solid);
  }
}

Place room_place(int bay, double side) {
  return {.base = {side * kAway, (bay - 0.5 * (kBays - 1)) * kPitch, 0}, .yaw = -side * kQuarter};
}

int cover_of_floor(Builder& builder) {
  switch (builder.random.below(3)) {
    case 0:
      return add_material(builder, Pattern::kWood, {40, 60, 85}, {125, 165, 200}, 0.9);
    case 1:
      return add_material(builder, Pattern::kCarpet, {75, 65, 60}, {140, 130, 125}, 1.0);
    default:
      return add_material(builder, Pattern::kTiles, {95, 100, 105}, {205, 210, 212}, 1.6);
  }
}

void add_shell(Builder& builder) {
  const int paint = add_material(builder, Pattern::kPlaster, {145, 160, 165}, {220, 230, 233}, 1.7);
  const int ceiling =
      add_material(builder, Pattern::kPlaster, {215, 218, 220}, {240, 242, 243}, 2.0);
  add_box(builder, {}, {kWidth, kDepth, kSlab}, cover_of_floor(builder));
  add_box(builder, {.base = {0, 0, kHeight - kSlab}}, {kWidth, kDepth, kSlab}, ceiling);
  add_box(builder, {.base = {0, (kDepth + kPartition) / 2, 0}}, {kPitch, kPartition, kHeight},
          paint);
  for (const double side : {-1.0, 1.0})
    add_box(builder, {.base = {side * (kWidth + kPartition) / 2, 0, 0}},
            {kPartition, kDepth, kHeight}, paint);
  const double y = -(kDepth + kFront) / 2;
  const double left = kDoor - kDoorWidth / 2, right = kDoor + kDoorWidth / 2, end = kPitch / 2;
  add_box(builder, {.base = {(left - end) / 2, y, 0}}, {left + end, kFront, kHeight}, paint);
  add_box(builder, {.base = {(right + end) / 2, y, 0}}, {end - right, kFront, kHeight}, paint);
  add_box(builder, {.base = {kDoor, y, kDoorHeight}}, {kDoorWidth, kFront, kHeight - kDoorHeight},
          paint);
  constexpr double kFrame = 0.07;  // [m]
  const int frame = add_material(builder, Pattern::kWood, {40, 55, 75}, {105, 135, 160}, 0.8);
  for (const double x : {left + kFrame / 2, right - kFrame / 2})
    add_box(builder, {.base = {x, y, 0}}, {kFrame, kFront + 0.03, kDoorHeight}, frame);
  add_box(builder, {.base = {kDoor, y, kDoorHeight - kFrame}}, {kDoorWidth, kFront + 0.03, kFrame},
          frame);
}

void add_posters(Builder& builder, const Place& wall, double from, double to) {
  for (double x = from; x < to; x += 0.95) {
    const double width = builder.random.uniform(0.45, 0.8);
    const double height = builder.random.uniform(0.45, 0.9);
    add_poster(builder, beside(wall, {x + 0.4, -0.01, builder.random.uniform(1.1, 1.4)}), width,
               height);
  }
}

// The wall across from the door has room for what is deep.
void furnish_back(Builder& builder, const Place& wall) {
  switch (builder.random.below(3)) {
    case 0:
      add_desk(builder, beside(wall, {0.4, -0.42, 0}), 1.8);
      add_chair(builder, beside(wall, {0.2, -1.0, 0}, 2.8));
      add_posters(builder, wall, -1.8, 1.5);
      break;
    case 1:
      add_sofa(builder, beside(wall, {-0.2, -0.45, 0}));
      add_lamp(builder, beside(wall, {1.3, -0.3, 0}), 1.7);
      add_posters(builder, wall, -1.6, 1.0);
      break;
    default:
      add_shelf(builder, beside(wall, {-0.9, -0.17, 0}), 1.4, 2.0);
      add_plant(builder, beside(wall, {1.7, -0.4, 0}), 1.5);
      add_posters(builder, wall, 0.0, 1.0);
  }
}

void furnish_side(Builder& builder, const Place& wall) {
  switch (builder.random.below(3)) {
    case 0:
      add_shelf(builder, beside(wall, {0.3, -0.17, 0}), 1.2, 1.6);
      add_posters(builder, wall, -2.3, -0.5);
      add_posters(builder, wall, 1.1, 1.6);
      break;
    case 1:
      add_window(builder, beside(wall, {-0.5, -0.01, 0.95}), 1.1, 1.2);
      add_plant(builder, beside(wall, {1.5, -0.35, 0}), 1.2);
      add_posters(builder, wall, -2.2, -1.3);
      add_posters(builder, wall, 0.3, 1.6);
      break;
    default: {
      const int wood = add_material(builder, Pattern::kWood, {60, 80, 100}, {150, 185, 210}, 1.2);
      add_box(builder, beside(wall, {0, -0.24, 0}), {1.6, 0.45, 0.6}, wood);
      add_monitor(builder, beside(wall, {-0.3, -0.24, 0.6}));
      add_book(builder, beside(wall, {0.5, -0.24, 0.6}, 0.3));
      add_posters(builder, wall, -2.3, 1.6);
    }
  }
}

// About the middle the way is free; the corridor's side of the front wall belongs to the room.
void furnish_room(Builder& builder) {
  add_shell(builder);
  furnish_back(builder, {.base = {0, kDepth / 2, 0}});
  furnish_side(builder, {.base = {-kWidth / 2, 0, 0}, .yaw = kQuarter});
  furnish_side(builder, {.base = {kWidth / 2, 0, 0}, .yaw = -kQuarter});
  const Place front{.base = {0, -kDepth / 2, 0}, .yaw = 2 * kQuarter};
  add_posters(builder, front, -2.3, 0.1);
  add_poster(builder, beside(front, {1.95, -0.01, 1.1}), 0.5, 0.7);
  add_posters(builder, {.base = {0, -kDepth / 2 - kFront, 0}}, -0.5, 1.6);
  const int board = add_material(builder, Pattern::kWood, {25, 40, 60}, {80, 115, 150}, 0.7);
  const Place table{.base = {0, -0.4, 0}};
  add_table(builder, table, {0.9, 0.6, 0.45}, board);
  add_book(builder, beside(table, {0.2, 0.1, 0.45}, builder.random.uniform(-1, 1)));
  add_mug(builder, beside(table, {-0.2, 0.05, 0.45}));
}

// In through the door, around the table, and out again; in the frame of the room.
std::vector<Eigen::Vector3d> room_round() {
  constexpr double kOutside = -kDepth / 2 - kFront - kHalfAisle;
  return {{kDoor, kOutside, 0}, {kDoor, 0.6, 0},  {-kDoor, 0.6, 0},
          {-kDoor, -1.4, 0},    {kDoor, -1.4, 0}, {kDoor, kOutside, 0}};
}

// Both ends of a corridor or an aisle along y, and what lies between.
void furnish_ends(Builder& builder, double half_length) {
  for (const double side : {-1.0, 1.0}) {
    const Place wall{.base = {0, side * half_length, 0}, .yaw = side > 0 ? 0 : 2 * kQuarter};
    add_poster(builder, beside(wall, {-0.4, -0.01, 1.2}), 0.7, 0.8);
    add_poster(builder, beside(wall, {0.45, -0.01, 1.0}), 0.6, 0.9);
    add_plant(builder, beside(wall, {0.7, -0.2, 0}), 0.8);
  }
}

WalkPlan walk_along(double half_length) {
  constexpr double kRoomToTurn = 0.9, kStart = 2.6;  // [m]
  return {.south = {0, kRoomToTurn - half_length, 0},
          .home = {0, kStart - half_length, 0},
          .north = {0, half_length - kRoomToTurn, 0},
          .rounds = {}};
}

}  // namespace

void furnish_flat(Builder& builder, Likeness likeness) {
  const int paint = add_material(builder, Pattern::kPlaster, {145, 160, 165}, {220, 230, 233}, 1.7);
  const int tiles = add_material(builder, Pattern::kTiles, {95, 100, 105}, {205, 210, 212}, 1.6);
  const double half_x = kAway + kDepth / 2 + kPartition;
  add_room(builder, {2 * half_x, 2 * kHalfLength, kHeight}, paint, tiles, paint);
  builder.scene.light = kFarAbove;
  builder.scene.walk = walk_along(kHalfLength);
  furnish_ends(builder, kHalfLength);
  Solids room;
  for (int bay = 0; bay < kBays; ++bay)
    for (const double side : {-1.0, 1.0}) {
      const Place place = room_place(bay, side);
      if (room.empty() || likeness == Likeness::kNone)
        room = made_by(builder, [&] { furnish_room(builder); });
      stand(builder, room, place);
      if (likeness == Likeness::kPoster)
        add_poster(builder, beside(place, {kWidth / 2 - 0.02, -1.2, 1.2}, -kQuarter), 0.9, 0.7);
      std::vector<Eigen::Vector3d> round = room_round();
      for (Eigen::Vector3d& point : round) point = pose_of(place) * point;
      builder.scene.walk.rounds.push_back(round);
    }
  builder.scene.stage = {.eye = {0, builder.scene.walk.home.y() + 2, 1.35},
                         .target = {0, 2, 1.1},
                         .reach = {0.25, 1.2, 0.15}};
}

// Walls and floor repeat as the desks do.
void furnish_desk_rows(Builder& builder) {
  constexpr int kDesks = 6;
  constexpr double kApart = 2, kHalfWidth = 2.2, kHalf = kDesks * kApart / 2 + 0.6;  // [m]
  const int paint = add_material(builder, Pattern::kPlaster, {165, 180, 185}, {215, 225, 228}, 2.0);
  const int carpet = add_material(builder, Pattern::kCarpet, {75, 65, 60}, {140, 130, 125}, 1.0);
  add_room(builder, {2 * kHalfWidth, 2 * kHalf, kHeight}, paint, carpet, paint);
  builder.scene.light = kFarAbove;
  builder.scene.walk = walk_along(kHalf);
  furnish_ends(builder, kHalf);
  const Solids desk = made_by(builder, [&] {
    add_desk(builder, {.base = {0, -0.42, 0}}, 1.6);
    add_chair(builder, {.base = {0.1, -1.0, 0}, .yaw = 2.9});
    add_poster(builder, {.base = {-0.3, -0.01, 1.4}}, 0.6, 0.7);
  });
  for (int i = 0; i < kDesks; ++i)
    for (const double side : {-1.0, 1.0})
      stand(builder, desk,
            {.base = {side * kHalfWidth, (i - 0.5 * (kDesks - 1)) * kApart, 0},
             .yaw = -side * kQuarter});
  builder.scene.stage = {.eye = {0, -2, 1.35}, .target = {0, 2, 1.0}, .reach = {0.25, 1.6, 0.15}};
}

}  // namespace edvo::synth
