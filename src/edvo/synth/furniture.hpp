// SPDX-License-Identifier: MIT
// What rooms are furnished with. Each function stands its piece into the room of a builder.
#pragma once

#include "edvo/synth/random.hpp"
#include "edvo/synth/scene.hpp"

#include <map>
#include <utility>

namespace edvo::synth {

struct Builder {
  Scene scene;
  Random random;
  std::map<std::pair<Pattern, int>, int> painted;  // pattern and variant -> index of its texture
};

// BGR [0..255].
using Colour = Eigen::Vector3f;

// A square footprint on the floor or on a surface: the middle of its base, and the turn about z.
struct Place {
  Eigen::Vector3d base = Eigen::Vector3d::Zero();  // [m]
  double yaw = 0;                                  // [rad]; 0: the front looks to -y
};

// The place that lies at an offset [m] in the frame of another.
[[nodiscard]] Place beside(const Place& place, const Eigen::Vector3d& offset, double turn = 0);

[[nodiscard]] int add_material(Builder& builder, Pattern pattern, const Colour& dark,
                               const Colour& bright, double tile = 0);

void add_box(Builder& builder, const Place& place, const Eigen::Vector3d& size, int material);
void add_box(Builder& builder, const Place& place, const Eigen::Vector3d& size,
             const std::array<int, 6>& materials);
void add_sphere(Builder& builder, const Eigen::Vector3d& centre, double radius, int material);
void add_cylinder(Builder& builder, const Place& place, double radius, double height, int material);

void add_room(Builder& builder, const Eigen::Vector3d& size, int walls, int floor, int ceiling);
void add_poster(Builder& builder, const Place& place, double width, double height);
void add_table(Builder& builder, const Place& place, const Eigen::Vector3d& size, int material);
void add_monitor(Builder& builder, const Place& place);
void add_keyboard(Builder& builder, const Place& place);
void add_book(Builder& builder, const Place& place);
void add_book_row(Builder& builder, const Place& place, double width);
void add_mug(Builder& builder, const Place& place);
void add_shelf(Builder& builder, const Place& place, double width, double height);
void add_chair(Builder& builder, const Place& place);
void add_sofa(Builder& builder, const Place& place);
void add_plant(Builder& builder, const Place& place, double height);
void add_lamp(Builder& builder, const Place& place, double height);
void add_skirting(Builder& builder, const Eigen::Vector3d& room);
void add_window(Builder& builder, const Place& place, double width, double height);
void add_door(Builder& builder, const Place& place);
void add_desk(Builder& builder, const Place& place, double width);  // a table with things on it

}  // namespace edvo::synth
