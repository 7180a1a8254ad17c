// SPDX-License-Identifier: MIT
#include "edvo/synth/furniture.hpp"

#include <numbers>

namespace edvo::synth {
namespace {

SE3 pose_of(const Place& place, double height_of_middle) {
  return {.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(place.yaw, Eigen::Vector3d::UnitZ())),
          .translation = place.base + Eigen::Vector3d{0, 0, height_of_middle}};
}

Colour random_colour(Random& random) {
  Colour colour;
  for (int channel = 0; channel < 3; ++channel)
    colour[channel] = static_cast<float>(random.uniform(30, 230));
  return colour;
}

// Dark print on something brighter, as most covers are.
int random_cover(Builder& builder, Pattern pattern) {
  const Colour dark = random_colour(builder.random) * 0.35F;
  const Colour bright = random_colour(builder.random) * 0.6F + Colour::Constant(100);
  return add_material(builder, pattern, dark, bright);
}

// Textures are large: pieces share them and differ in colour.
int variants_of(Pattern pattern) {
  switch (pattern) {
    case Pattern::kPoster:
      return 5;
    case Pattern::kBook:
      return 4;
    case Pattern::kScreen:
      return 2;
    default:
      return 1;
  }
}

int wood(Builder& builder) {
  return add_material(builder, Pattern::kWood, {30, 55, 90}, {120, 175, 220}, 1.1);
}

int plain(Builder& builder, const Colour& colour) {
  return add_material(builder, Pattern::kPlaster, colour * 0.85F, colour * 1.1F, 0.7);
}

}  // namespace

Place beside(const Place& place, const Eigen::Vector3d& offset, double turn) {
  return {.base = pose_of(place, 0) * offset, .yaw = place.yaw + turn};
}

int add_material(Builder& builder, Pattern pattern, const Colour& dark, const Colour& bright,
                 double tile) {
  Scene& scene = builder.scene;
  const int variant = builder.random.below(variants_of(pattern));
  const auto [known, is_new] = builder.painted.try_emplace(std::pair{pattern, variant},
                                                           static_cast<int>(scene.textures.size()));
  if (is_new) scene.textures.push_back(make_texture(pattern, builder.random.word()));
  scene.materials.push_back({.texture = known->second,
                             .dark = dark,
                             .bright = bright,
                             .tile = Eigen::Vector2f::Constant(static_cast<float>(tile))});
  return static_cast<int>(scene.materials.size()) - 1;
}

void add_box(Builder& builder, const Place& place, const Eigen::Vector3d& size,
             const std::array<int, 6>& materials) {
  builder.scene.solids.push_back({.shape = Shape::kBox,
                                  .world_from_solid = pose_of(place, size.z() / 2),
                                  .half = (size / 2).cast<float>(),
                                  .materials = materials});
}

void add_box(Builder& builder, const Place& place, const Eigen::Vector3d& size, int material) {
  std::array<int, 6> materials;
  materials.fill(material);
  add_box(builder, place, size, materials);
}

void add_sphere(Builder& builder, const Eigen::Vector3d& centre, double radius, int material) {
  builder.scene.solids.push_back({.shape = Shape::kSphere,
                                  .world_from_solid = {.translation = centre},
                                  .half = Eigen::Vector3f::Constant(static_cast<float>(radius)),
                                  .materials = {material}});
}

void add_cylinder(Builder& builder, const Place& place, double radius, double height,
                  int material) {
  builder.scene.solids.push_back({.shape = Shape::kCylinder,
                                  .world_from_solid = pose_of(place, height / 2),
                                  .half = Eigen::Vector3d{radius, radius, height / 2}.cast<float>(),
                                  .materials = {material}});
}

void add_room(Builder& builder, const Eigen::Vector3d& size, int walls, int floor, int ceiling) {
  builder.scene.solids.push_back({.shape = Shape::kRoom,
                                  .world_from_solid = {.translation = {0, 0, size.z() / 2}},
                                  .half = (size / 2).cast<float>(),
                                  .materials = {walls, walls, walls, walls, floor, ceiling}});
  builder.scene.light = {0.2F * static_cast<float>(size.x()), -0.15F * static_cast<float>(size.y()),
                         0.92F * static_cast<float>(size.z())};
}

void add_poster(Builder& builder, const Place& place, double width, double height) {
  add_box(builder, place, {width, 0.012, height}, random_cover(builder, Pattern::kPoster));
}

void add_table(Builder& builder, const Place& place, const Eigen::Vector3d& size, int material) {
  constexpr double kTop = 0.03, kLeg = 0.05;  // [m]
  add_box(builder, beside(place, {0, 0, size.z() - kTop}), {size.x(), size.y(), kTop}, material);
  for (const double sx : {-1.0, 1.0})
    for (const double sy : {-1.0, 1.0})
      add_box(builder, beside(place, {sx * (size.x() / 2 - kLeg), sy * (size.y() / 2 - kLeg), 0}),
              {kLeg, kLeg, size.z() - kTop}, material);
}

void add_monitor(Builder& builder, const Place& place) {
  const int shell = plain(builder, {45, 42, 40});
  const int screen = add_material(builder, Pattern::kScreen, {25, 20, 15}, {245, 235, 225});
  add_box(builder, place, {0.24, 0.18, 0.015}, shell);
  add_box(builder, beside(place, {0, 0.03, 0.015}), {0.06, 0.04, 0.12}, shell);
  add_box(builder, beside(place, {0, 0, 0.11}), {0.54, 0.045, 0.33},
          {shell, shell, screen, shell, shell, shell});
}

void add_keyboard(Builder& builder, const Place& place) {
  const int shell = plain(builder, {60, 60, 60});
  const int keys = add_material(builder, Pattern::kKeys, {20, 20, 22}, {210, 215, 220});
  add_box(builder, place, {0.44, 0.15, 0.025}, {shell, shell, shell, shell, shell, keys});
}

void add_book(Builder& builder, const Place& place) {
  Random& random = builder.random;
  const int cover = random_cover(builder, Pattern::kPoster);
  const int pages =
      add_material(builder, Pattern::kStripes, {190, 200, 205}, {225, 232, 235}, 0.08);
  add_box(builder, place,
          {random.uniform(0.14, 0.2), random.uniform(0.2, 0.27), random.uniform(0.015, 0.05)},
          {pages, pages, pages, pages, cover, cover});
}

void add_book_row(Builder& builder, const Place& place, double width) {
  Random& random = builder.random;
  for (double x = -width / 2; x < width / 2 - 0.06;) {
    const double thickness = random.uniform(0.02, 0.055);
    if (random.uniform() < 0.85) {  // one draw in a statement: compilers differ in their order
      const int cover = random_cover(builder, Pattern::kBook);
      const double height = random.uniform(0.18, 0.27);
      const double out = random.uniform(-0.03, 0.01);
      add_box(builder, beside(place, {x + thickness / 2, out, 0}),
              {thickness - 0.002, 0.18, height}, cover);
    }
    x += thickness;
  }
}

void add_mug(Builder& builder, const Place& place) {
  add_cylinder(builder, place, 0.04, 0.1, random_cover(builder, Pattern::kStripes));
}

void add_shelf(Builder& builder, const Place& place, double width, double height) {
  constexpr double kBoard = 0.022, kDepth = 0.3, kPitch = 0.36;  // [m]
  const int board = wood(builder);
  for (const double side : {-1.0, 1.0})
    add_box(builder, beside(place, {side * (width - kBoard) / 2, 0, 0}), {kBoard, kDepth, height},
            board);
  add_box(builder, beside(place, {0, kDepth / 2, 0}), {width, 0.01, height}, board);
  for (double z = 0; z < height - 0.1; z += kPitch) {
    add_box(builder, beside(place, {0, 0, z}), {width - 2 * kBoard, kDepth, kBoard}, board);
    if (z + kPitch < height)
      add_book_row(builder, beside(place, {0, 0, z + kBoard}), width - 2 * kBoard);
  }
}

void add_chair(Builder& builder, const Place& place) {
  const Colour bright = random_colour(builder.random);
  const Colour dark = random_colour(builder.random) * 0.3F;
  const int cloth = add_material(builder, Pattern::kFabric, dark, bright, 0.3);
  const int metal = plain(builder, {90, 90, 95});
  add_box(builder, beside(place, {0, 0, 0.42}), {0.44, 0.44, 0.07}, cloth);
  add_box(builder, beside(place, {0, 0.21, 0.55}), {0.42, 0.05, 0.42}, cloth);
  add_cylinder(builder, beside(place, {0, 0, 0.05}), 0.03, 0.37, metal);
  add_box(builder, place, {0.5, 0.06, 0.05}, metal);
  add_box(builder, place, {0.06, 0.5, 0.05}, metal);
}

void add_sofa(Builder& builder, const Place& place) {
  const int cloth = add_material(builder, Pattern::kFabric, {60, 40, 45}, {190, 150, 150}, 0.4);
  const int cushion = random_cover(builder, Pattern::kStripes);
  add_box(builder, place, {1.9, 0.85, 0.42}, cloth);
  add_box(builder, beside(place, {0, 0.33, 0.42}), {1.9, 0.2, 0.4}, cloth);
  for (const double side : {-1.0, 1.0}) {
    add_box(builder, beside(place, {side * 0.87, 0, 0.42}), {0.16, 0.85, 0.2}, cloth);
    add_box(builder, beside(place, {side * 0.45, 0.12, 0.42}, side * 0.3), {0.42, 0.14, 0.38},
            cushion);
  }
}

void add_plant(Builder& builder, const Place& place, double height) {
  Random& random = builder.random;
  const int pot = plain(builder, {60, 90, 170});
  const int leaf = add_material(builder, Pattern::kSpeckle, {15, 50, 15}, {70, 170, 90}, 0.25);
  add_cylinder(builder, place, 0.2 * height, 0.3 * height, pot);
  add_cylinder(builder, beside(place, {0, 0, 0.3 * height}), 0.02 * height, 0.35 * height, pot);
  for (int i = 0; i < 9; ++i) {
    const double angle = i * 2.4, away = random.uniform(0.02, 0.2) * height;  // golden angle
    const Eigen::Vector3d offset{away * std::cos(angle), away * std::sin(angle),
                                 random.uniform(0.55, 0.92) * height};
    add_sphere(builder, place.base + offset, random.uniform(0.06, 0.12) * height, leaf);
  }
}

void add_lamp(Builder& builder, const Place& place, double height) {
  add_cylinder(builder, place, 0.13, 0.03, plain(builder, {50, 50, 55}));
  add_cylinder(builder, place, 0.012, height - 0.2, plain(builder, {80, 80, 85}));
  add_cylinder(builder, beside(place, {0, 0, height - 0.25}), 0.16, 0.25,
               add_material(builder, Pattern::kFabric, {140, 190, 215}, {200, 240, 250}, 0.3));
}

void add_skirting(Builder& builder, const Eigen::Vector3d& room) {
  constexpr double kThickness = 0.02, kHeight = 0.08;  // [m]
  const int board = plain(builder, {85, 92, 98});
  for (const double side : {-1.0, 1.0}) {
    add_box(builder, {.base = {side * (room.x() - kThickness) / 2, 0, 0}},
            {kThickness, room.y(), kHeight}, board);
    add_box(builder, {.base = {0, side * (room.y() - kThickness) / 2, 0}},
            {room.x(), kThickness, kHeight}, board);
  }
}

void add_window(Builder& builder, const Place& place, double width, double height) {
  constexpr double kBar = 0.06;  // [m]
  const int frame = plain(builder, {225, 228, 230});
  const int sky = add_material(builder, Pattern::kPlaster, {235, 190, 150}, {255, 250, 245});
  add_box(builder, place, {width, 0.02, height}, sky);
  for (const double x : {-0.5, 0.0, 0.5})
    add_box(builder, beside(place, {x * (width - kBar), -0.02, 0}), {kBar, 0.05, height}, frame);
  for (const double z : {0.0, 0.62, 1.0})
    add_box(builder, beside(place, {0, -0.02, z * (height - kBar)}), {width, 0.05, kBar}, frame);
}

void add_door(Builder& builder, const Place& place) {
  const int frame = plain(builder, {120, 130, 140});
  add_box(builder, place, {1.02, 0.06, 2.08}, frame);
  add_box(builder, place, {0.88, 0.09, 2.0}, wood(builder));
  add_box(builder, beside(place, {0.36, -0.07, 1.03}), {0.12, 0.03, 0.025},
          plain(builder, {170, 175, 180}));
}

void add_desk(Builder& builder, const Place& place, double width) {
  constexpr double kHeight = 0.74, kDepth = 0.8;  // [m]
  Random& random = builder.random;
  add_table(builder, place, {width, kDepth, kHeight}, wood(builder));
  const Place top = beside(place, {0, 0, kHeight});
  add_monitor(builder, beside(top, {-0.22 * width, 0.18, 0}, 0.25));
  add_monitor(builder, beside(top, {0.17 * width, 0.2, 0}, -0.15));
  add_keyboard(builder, beside(top, {-0.03 * width, -0.17, 0}, random.uniform(-0.1, 0.1)));
  add_mug(builder, beside(top, {0.25 * width, -0.12, 0}));
  add_mug(builder, beside(top, {-0.3 * width, -0.2, 0}));
  for (int pile = 0; pile < 3; ++pile) {
    const Place spot = beside(top, {(0.3 + 0.04 * pile) * width * (pile == 1 ? -1.15 : 1),
                                    random.uniform(-0.28, -0.18), 0});
    for (int book = 0; book < 2; ++book)
      add_book(builder, beside(spot, {0, 0, 0.05 * book}, random.uniform(-0.6, 0.6)));
  }
  add_sphere(builder, top.base + Eigen::Vector3d{0.02, 0, 0.045}, 0.045,
             random_cover(builder, Pattern::kStripes));
  add_box(builder, beside(top, {0.44 * width, 0.1, 0}, 0.1), {0.1, 0.2, 0.26},
          random_cover(builder, Pattern::kPoster));
}

}  // namespace edvo::synth
