// SPDX-License-Identifier: MIT
#include "edvo/synth/shadow.hpp"

#include "edvo/core/inplace_vector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace edvo::synth {
namespace {

constexpr int kLampPoints = 8;         // the corners of a cube in the lamp
constexpr std::size_t kMostNear = 64;  // casters near one line of sight; more make no difference
constexpr float kContact = 1e-3F;      // a surface does not touch what stands on it [m]

// Where a line from `start` along `direction` is inside, as shares of its length: empty if never.
using Inside = std::pair<float, float>;

Inside inside_slabs(const Eigen::Vector3f& start, const Eigen::Vector3f& direction,
                    const Eigen::Vector3f& half, int axes) {
  Inside inside{-1e9F, 1e9F};
  for (int axis = 3 - axes; axis < 3; ++axis) {
    const float slope = std::abs(direction[axis]) < 1e-9F ? 1e9F : 1 / direction[axis];
    const float a = (-half[axis] - start[axis]) * slope, b = (half[axis] - start[axis]) * slope;
    inside = {std::max(inside.first, std::min(a, b)), std::min(inside.second, std::max(a, b))};
  }
  return inside;
}

Inside inside_round(float dd, float od, float oo_minus_rr) {
  const float discriminant = od * od - dd * oo_minus_rr;
  if (discriminant <= 0 || dd <= 0) return {1, 0};
  const float root = std::sqrt(discriminant);
  return {(-od - root) / dd, (-od + root) / dd};
}

bool is_between(const Caster& caster, const Eigen::Vector3f& start,
                const Eigen::Vector3f& direction) {
  Inside inside{1, 0};
  if (caster.shape == Shape::kSphere) {
    inside = inside_round(direction.squaredNorm(), start.dot(direction),
                          start.squaredNorm() - caster.half.x() * caster.half.x());
  } else if (caster.shape == Shape::kCylinder) {
    const Eigen::Vector2f o = start.head<2>(), d = direction.head<2>();
    const Inside side = inside_round(d.squaredNorm(), o.dot(d),
                                     o.squaredNorm() - caster.half.x() * caster.half.x());
    const Inside slab = inside_slabs(start, direction, caster.half, 1);
    inside = {std::max(side.first, slab.first), std::min(side.second, slab.second)};
  } else {
    inside = inside_slabs(start, direction, caster.half, 3);
  }
  const float contact = kContact / direction.norm();
  return std::max(inside.first, contact) < std::min(inside.second, 1.0F);
}

bool is_near(const Caster& caster, const Eigen::Vector3f& point, const Eigen::Vector3f& to_lamp) {
  const Eigen::Vector3f to_middle = caster.middle - point;
  const float share = std::clamp(to_middle.dot(to_lamp) / to_lamp.squaredNorm(), 0.0F, 1.0F);
  const float reach = caster.radius + kLampRadius;
  return (to_middle - share * to_lamp).squaredNorm() < reach * reach;
}

}  // namespace

std::vector<Caster> casters_of(const Scene& scene, double seconds) {
  std::vector<Caster> casters;
  for (std::size_t i = 0; i < scene.solids.size(); ++i) {
    const Solid& solid = scene.solids[i];
    if (solid.shape == Shape::kRoom) continue;
    const SE3 world_from_solid = pose_at(solid, seconds);
    const SE3 solid_from_world = inverse(world_from_solid);
    casters.push_back({.shape = solid.shape,
                       .solid = static_cast<int>(i),
                       .half = solid.half,
                       .rotation = solid_from_world.rotation.toRotationMatrix().cast<float>(),
                       .origin = solid_from_world.translation.cast<float>(),
                       .middle = world_from_solid.translation.cast<float>(),
                       .radius = solid.half.norm()});
  }
  return casters;
}

float lamp_share(const std::vector<Caster>& casters, int solid, const Eigen::Vector3f& point,
                 const Eigen::Vector3f& lamp) {
  const Eigen::Vector3f to_lamp = lamp - point;
  InplaceVector<const Caster*, kMostNear> near;
  for (const Caster& caster : casters)
    if (caster.solid != solid && near.size() < kMostNear && is_near(caster, point, to_lamp))
      near.push_back(&caster);
  if (near.empty()) return 1;
  const float side = kLampRadius / std::sqrt(3.0F);
  int seen = 0;
  for (int i = 0; i < kLampPoints; ++i) {
    const Eigen::Vector3f corner((i & 1) != 0 ? side : -side, (i & 2) != 0 ? side : -side,
                                 (i & 4) != 0 ? side : -side);
    const bool hidden = std::any_of(near.begin(), near.end(), [&](const Caster* caster) {
      return is_between(*caster, caster->rotation * point + caster->origin,
                        caster->rotation * (to_lamp + corner));
    });
    seen += hidden ? 0 : 1;
  }
  return static_cast<float>(seen) / kLampPoints;
}

}  // namespace edvo::synth
