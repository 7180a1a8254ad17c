// SPDX-License-Identifier: MIT
#include "edvo/synth/scene.hpp"

#include "edvo/synth/flat.hpp"
#include "edvo/synth/furniture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace edvo::synth {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;  // [rad]

int wall_paint(Builder& builder) {
  return add_material(builder, Pattern::kPlaster, {165, 180, 185}, {215, 225, 228}, 1.7);
}

int ceiling_paint(Builder& builder) {
  return add_material(builder, Pattern::kPlaster, {215, 218, 220}, {240, 242, 243}, 2.0);
}

int wooden_floor(Builder& builder) {
  return add_material(builder, Pattern::kWood, {40, 60, 85}, {125, 165, 200}, 0.9);
}

void furnish_desk(Builder& builder) {
  add_room(builder, {4.4, 4.2, 2.6}, wall_paint(builder), wooden_floor(builder),
           ceiling_paint(builder));
  add_desk(builder, {.base = {0, 1.6, 0}}, 2.0);
  add_poster(builder, {.base = {-0.75, 2.09, 1.35}}, 0.6, 0.8);
  add_poster(builder, {.base = {0.15, 2.09, 1.45}}, 0.8, 0.6);
  add_poster(builder, {.base = {0.95, 2.09, 1.3}}, 0.45, 0.65);
  add_shelf(builder, {.base = {-1.85, 1.9, 0}}, 0.7, 2.0);
  add_plant(builder, {.base = {1.75, 1.6, 0}}, 1.3);
  add_chair(builder, {.base = {1.45, 0.6, 0}, .yaw = 2.2});
  add_door(builder, {.base = {0.6, -2.07, 0}, .yaw = 2 * kQuarter});
  add_shelf(builder, {.base = {-2.0, -0.8, 0}, .yaw = kQuarter}, 1.2, 1.9);
  add_poster(builder, {.base = {2.19, -0.6, 1.2}, .yaw = -kQuarter}, 0.9, 0.7);
  add_window(builder, {.base = {2.19, 0.7, 0.95}, .yaw = -kQuarter}, 1.1, 1.2);
  add_skirting(builder, {4.4, 4.2, 2.6});
  builder.scene.stage = {
      .eye = {0, 0.35, 1.25}, .target = {0, 1.7, 0.85}, .reach = {0.5, 0.25, 0.2}};
}

void furnish_office(Builder& builder) {
  const int carpet = add_material(builder, Pattern::kCarpet, {75, 65, 60}, {140, 130, 125}, 1.0);
  add_room(builder, {5.4, 5.0, 2.7}, wall_paint(builder), carpet, ceiling_paint(builder));
  add_desk(builder, {.base = {-0.9, 2.05, 0}}, 1.6);
  add_desk(builder, {.base = {0.9, 2.05, 0}}, 1.6);
  add_desk(builder, {.base = {2.25, 0.2, 0}, .yaw = -kQuarter}, 1.6);
  add_chair(builder, {.base = {-0.9, 1.3, 0}, .yaw = 3.4});
  add_chair(builder, {.base = {0.85, 1.35, 0}, .yaw = 2.8});
  add_chair(builder, {.base = {1.6, 0.3, 0}, .yaw = 1.4});
  add_shelf(builder, {.base = {-2.5, 0.9, 0}, .yaw = kQuarter}, 1.2, 2.0);
  add_shelf(builder, {.base = {-2.5, -0.6, 0}, .yaw = kQuarter}, 1.2, 1.6);
  add_shelf(builder, {.base = {-1.2, -2.3, 0}, .yaw = 2 * kQuarter}, 1.4, 2.0);
  add_door(builder, {.base = {0.8, -2.47, 0}, .yaw = 2 * kQuarter});
  add_plant(builder, {.base = {2.3, -1.9, 0}}, 1.4);
  add_plant(builder, {.base = {-2.3, 2.1, 0}}, 1.6);
  for (int i = 0; i < 4; ++i)
    add_poster(builder, {.base = {-1.6 + 1.1 * i, 2.49, 1.35 + 0.08 * (i % 2)}}, 0.7, 0.85);
  add_skirting(builder, {5.4, 5.0, 2.7});
  add_window(builder, {.base = {2.69, -1.6, 0.95}, .yaw = -kQuarter}, 1.1, 1.3);
  add_poster(builder, {.base = {2.69, 0.9, 1.35}, .yaw = -kQuarter}, 0.9, 0.65);
  add_poster(builder, {.base = {2.69, -0.5, 1.3}, .yaw = -kQuarter}, 0.6, 0.85);
  add_poster(builder, {.base = {-0.1, -2.49, 1.25}, .yaw = 2 * kQuarter}, 0.6, 0.8);
  builder.scene.stage = {
      .eye = {-0.1, -0.1, 1.35}, .target = {0.1, 2.0, 1.0}, .reach = {0.75, 0.45, 0.2}};
}

void furnish_living_room(Builder& builder) {
  add_room(builder, {5.2, 5.0, 2.6}, wall_paint(builder), wooden_floor(builder),
           ceiling_paint(builder));
  const int rug = add_material(builder, Pattern::kCarpet, {40, 35, 110}, {130, 150, 215}, 0.8);
  add_box(builder, {.base = {0, 0, 0}}, {2.6, 2.0, 0.012}, rug);
  const int board = add_material(builder, Pattern::kWood, {25, 40, 60}, {80, 115, 150}, 0.7);
  add_table(builder, {.base = {0, 0, 0}}, {1.1, 0.65, 0.42}, board);
  add_book(builder, {.base = {0.3, 0.1, 0.42}, .yaw = 0.4});
  add_book(builder, {.base = {-0.1, -0.12, 0.42}, .yaw = -0.7});
  add_mug(builder, {.base = {-0.35, 0.1, 0.42}});
  add_mug(builder, {.base = {0.1, 0.2, 0.42}});
  add_sofa(builder, {.base = {0.1, 2.0, 0}});
  add_sofa(builder, {.base = {2.1, 0, 0}, .yaw = -kQuarter});
  add_lamp(builder, {.base = {1.6, 2.2, 0}}, 1.7);
  add_plant(builder, {.base = {-1.5, 2.1, 0}}, 1.3);
  add_shelf(builder, {.base = {-2.4, 0.7, 0}, .yaw = kQuarter}, 1.6, 1.5);
  const int cabinet = add_material(builder, Pattern::kWood, {60, 80, 100}, {150, 185, 210}, 1.2);
  add_box(builder, {.base = {-0.4, -2.25, 0}}, {1.8, 0.45, 0.5}, cabinet);
  add_monitor(builder, {.base = {-0.4, -2.25, 0.5}, .yaw = 2 * kQuarter});
  add_door(builder, {.base = {1.7, -2.47, 0}, .yaw = 2 * kQuarter});
  add_poster(builder, {.base = {-0.5, 2.49, 1.2}}, 0.9, 0.7);
  add_poster(builder, {.base = {0.7, 2.49, 1.25}}, 0.6, 0.8);
  add_poster(builder, {.base = {2.59, 0.3, 1.2}, .yaw = -kQuarter}, 1.0, 0.75);
  add_poster(builder, {.base = {-2.59, -1.0, 1.2}, .yaw = kQuarter}, 0.7, 0.9);
  add_poster(builder, {.base = {-2.59, -1.9, 1.35}, .yaw = kQuarter}, 0.5, 0.6);
  add_poster(builder, {.base = {-0.9, -2.49, 1.3}, .yaw = 2 * kQuarter}, 0.6, 0.8);
  add_poster(builder, {.base = {0.5, -2.49, 1.2}, .yaw = 2 * kQuarter}, 0.9, 0.65);
  add_window(builder, {.base = {2.59, -1.5, 0.9}, .yaw = -kQuarter}, 1.2, 1.3);
  add_skirting(builder, {5.2, 5.0, 2.6});
  builder.scene.stage = {
      .eye = {-0.2, -0.3, 1.3}, .target = {0.3, 1.6, 0.75}, .reach = {0.75, 0.5, 0.2}};
}

void furnish_corridor(Builder& builder) {
  const int tiles = add_material(builder, Pattern::kTiles, {95, 100, 105}, {205, 210, 212}, 1.6);
  add_room(builder, {2.3, 13.0, 2.6}, wall_paint(builder), tiles, ceiling_paint(builder));
  const int lamp = add_material(builder, Pattern::kPlain, {250, 252, 252}, {250, 252, 252});
  const int skirting = add_material(builder, Pattern::kPlaster, {70, 75, 80}, {95, 100, 105}, 0.5);
  for (const double side : {-1.0, 1.0}) {
    const double yaw = -side * kQuarter;
    add_box(builder, {.base = {side * 1.145, 0, 0}}, {0.02, 13, 0.09}, skirting);
    for (int i = 0; i < 5; ++i) {
      const double y = -5.2 + 2.6 * i + 0.5 * side;
      add_door(builder, {.base = {side * 1.13, y, 0}, .yaw = yaw});
      add_poster(builder, {.base = {side * 1.14, y + 1.05, 1.15}, .yaw = yaw}, 0.5, 0.7);
      add_poster(builder, {.base = {side * 1.14, y + 1.6, 1.3}, .yaw = yaw}, 0.4, 0.5);
    }
  }
  for (int i = 0; i < 4; ++i) {
    add_box(builder, {.base = {0, -4.8 + 3.2 * i, 2.55}}, {0.3, 1.2, 0.05}, lamp);
    add_plant(builder, {.base = {i % 2 == 0 ? 0.9 : -0.9, -4.4 + 2.6 * i + 0.35, 0}}, 0.9);
  }
  builder.scene.light = {0, 0, 2.3F};
  builder.scene.stage = {
      .eye = {0, -3.0, 1.35}, .target = {0, 1.5, 1.0}, .reach = {0.25, 1.6, 0.15}};
}

void furnish_wall(Builder& builder) {
  const int white = add_material(builder, Pattern::kPlain, {225, 228, 230}, {225, 228, 230});
  add_room(builder, {8, 5, 4}, white, white, white);
  builder.scene.stage = {.eye = {0, 1.2, 2.0}, .target = {0, 2.5, 2.0}, .reach = {0.5, 0.2, 0.2}};
}

void furnish_boxes(Builder& builder) {
  Random& random = builder.random;
  const int tiles = add_material(builder, Pattern::kTiles, {60, 60, 65}, {200, 205, 210}, 1.6);
  const int bricks = add_material(builder, Pattern::kBricks, {45, 60, 130}, {170, 185, 200}, 1.5);
  add_room(builder, {6, 6, 3}, bricks, tiles, ceiling_paint(builder));
  constexpr int kCount = 22;
  constexpr std::array kPatterns = {Pattern::kSpeckle, Pattern::kFabric, Pattern::kPoster,
                                    Pattern::kStripes, Pattern::kWood,   Pattern::kCarpet};
  for (int i = 0; i < kCount; ++i) {
    const double angle = 2 * std::numbers::pi * (i + random.uniform(0, 0.6)) / kCount;
    const double away = random.uniform(1.7, 2.6);  // [m]
    const Place place{.base = {away * std::cos(angle), away * std::sin(angle), 0},
                      .yaw = random.uniform(0, kQuarter)};
    Colour dark, bright;
    for (int channel = 0; channel < 3; ++channel) {
      dark[channel] = static_cast<float>(random.uniform(10, 90));
      bright[channel] = static_cast<float>(random.uniform(120, 250));
    }
    const int cover = add_material(builder, kPatterns[i % kPatterns.size()], dark, bright, 0.5);
    const double size = random.uniform(0.25, 0.55), height = random.uniform(0.3, 1.6);
    if (i % 5 == 3)
      add_cylinder(builder, place, size / 2, height, cover);
    else
      add_box(builder, place, {size, size * random.uniform(0.6, 1.4), height}, cover);
    if (i % 4 == 1)
      add_sphere(builder, place.base + Eigen::Vector3d{0, 0, height + 0.18}, 0.18, cover);
  }
  builder.scene.stage = {.eye = {0, -0.3, 1.2}, .target = {0, 2, 0.8}, .reach = {0.7, 0.5, 0.25}};
}

double distance_to(const Solid& solid, const Eigen::Vector3d& point) {
  const Eigen::Vector3d local = inverse(solid.world_from_solid) * point;
  const Eigen::Vector3d half = solid.half.cast<double>();
  const auto box_distance = [](const auto& outside) {
    return outside.cwiseMax(0.0).norm() + std::min(outside.maxCoeff(), 0.0);
  };
  switch (solid.shape) {
    case Shape::kSphere:
      return local.norm() - half.x();
    case Shape::kCylinder:
      return box_distance(
          Eigen::Vector2d{local.head<2>().norm() - half.x(), std::abs(local.z()) - half.z()});
    case Shape::kBox:
      return box_distance(Eigen::Vector3d(local.cwiseAbs() - half));
    case Shape::kRoom:
      return (half - local.cwiseAbs()).minCoeff();
  }
  return 0;
}

}  // namespace

Scene make_scene(SceneName name, std::uint64_t seed) {
  Builder builder{
      .scene = {}, .random = Random{seed, static_cast<std::uint64_t>(name)}, .painted = {}};
  switch (name) {
    case SceneName::kDesk:
      furnish_desk(builder);
      break;
    case SceneName::kOffice:
      furnish_office(builder);
      break;
    case SceneName::kLivingRoom:
      furnish_living_room(builder);
      break;
    case SceneName::kCorridor:
      furnish_corridor(builder);
      break;
    case SceneName::kWall:
      furnish_wall(builder);
      break;
    case SceneName::kBoxes:
      furnish_boxes(builder);
      break;
    case SceneName::kFlat:
      furnish_flat(builder, Likeness::kNone);
      break;
    case SceneName::kPosters:
      furnish_flat(builder, Likeness::kPoster);
      break;
    case SceneName::kTwins:
      furnish_flat(builder, Likeness::kSame);
      break;
    case SceneName::kDeskRows:
      furnish_desk_rows(builder);
      break;
  }
  return std::move(builder.scene);
}

Eigen::Vector3f lamp_at(const Scene& scene, double seconds) {
  constexpr double kPeriod = 2;  // [s], of a lamp on a metre of cable
  const auto phase = static_cast<float>(std::sin(2 * std::numbers::pi * seconds / kPeriod));
  return scene.light + scene.lamp_swing * phase * Eigen::Vector3f::UnitX();
}

double clearance(const Scene& scene, const Eigen::Vector3d& point) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Solid& solid : scene.solids) {
    const double from_middle = (point - solid.world_from_solid.translation).norm();
    const bool too_far = from_middle - solid.half.norm() >= nearest;  // whatever its turn
    if (solid.shape == Shape::kRoom || !too_far)
      nearest = std::min(nearest, distance_to(solid, point));
  }
  return nearest;
}

}  // namespace edvo::synth
