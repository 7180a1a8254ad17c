// SPDX-License-Identifier: MIT
// How much of the lamp a point sees past the solids of a scene.
#pragma once

#include "edvo/synth/scene.hpp"

#include <Eigen/Core>
#include <vector>

namespace edvo::synth {

// A solid as the light sees it.
struct Caster {
  Shape shape = Shape::kBox;
  int solid = 0;                                           // index into Scene::solids
  Eigen::Vector3f half = Eigen::Vector3f::Zero();          // [m]
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();  // solid from world
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();        // of the world, in the solid [m]
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();        // of the solid, in the world [m]
  float radius = 0;                                        // of a ball around it [m]
};

// Every solid but the room.
[[nodiscard]] std::vector<Caster> casters_of(const Scene& scene, double seconds);

// Share [0..1] of a lamp of kLampRadius around `lamp` that is seen from a point of a solid, both in
// the world [m]; in eighths. A convex solid is no obstacle to itself.
inline constexpr float kLampRadius = 0.04F;  // [m]
[[nodiscard]] float lamp_share(const std::vector<Caster>& casters, int solid,
                               const Eigen::Vector3f& point, const Eigen::Vector3f& lamp);

}  // namespace edvo::synth
