// SPDX-License-Identifier: MIT
#include "edvo/synth/rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace edvo::synth {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kNearest = 0.01F;  // a camera sees nothing closer [m]

// Where a ray enters and leaves a box, or the infinite column of one. [m]
struct Stay {
  float enter = -kNothing, leave = kNothing;
};

inline Stay stay_in_box(const SolidInView& solid, float ray_x, float ray_y) {
  constexpr float kTiny = 1e-20F;  // instead of zero: no 0 / 0 for a ray inside a face's plane
  Stay stay;
  for (int axis = 0; axis < 3; ++axis) {
    float direction =
        solid.rotation(axis, 0) * ray_x + solid.rotation(axis, 1) * ray_y + solid.rotation(axis, 2);
    direction = std::abs(direction) < kTiny ? kTiny : direction;
    const float slope = 1 / direction;
    const float a = (-solid.half[axis] - solid.origin[axis]) * slope;
    const float b = (solid.half[axis] - solid.origin[axis]) * slope;
    stay.enter = std::max(stay.enter, std::min(a, b));
    stay.leave = std::min(stay.leave, std::max(a, b));
  }
  return stay;
}

// Nearer root of |o + t d|^2 = r^2 in the plane or in space.
float round_depth(float dd, float od, float oo_minus_rr) {
  const float discriminant = od * od - dd * oo_minus_rr;
  if (discriminant < 0) return kNothing;
  const float t = (-od - std::sqrt(discriminant)) / dd;
  return t > kNearest ? t : kNothing;
}

float cylinder_depth(const SolidInView& solid, float ray_x, float ray_y) {
  const Eigen::Vector3f& o = solid.origin;
  const Eigen::Vector3f d = solid.direction(ray_x, ray_y);
  const float radius = solid.half.x(), height = solid.half.z();
  const float side = round_depth(d.head<2>().squaredNorm(), o.head<2>().dot(d.head<2>()),
                                 o.head<2>().squaredNorm() - radius * radius);
  if (side < kNothing && std::abs(o.z() + side * d.z()) <= height) return side;
  const float cap = ((d.z() < 0 ? height : -height) - o.z()) / d.z();
  const float away2 = (o.head<2>() + cap * d.head<2>()).squaredNorm();
  return cap > kNearest && away2 <= radius * radius ? cap : kNothing;
}

float sphere_depth(const SolidInView& solid, float ray_x, float ray_y) {
  const Eigen::Vector3f d = solid.direction(ray_x, ray_y);
  return round_depth(d.squaredNorm(), solid.origin.dot(d),
                     solid.origin.squaredNorm() - solid.half.x() * solid.half.x());
}

using Depths = std::array<float, kPack>;  // [m]; kNothing: missed

Depths depths_of(const SolidInView& solid, const RayPack& rays) {
  Depths depths;
  switch (solid.shape) {
    case Shape::kBox:
      for (int i = 0; i < kPack; ++i) {
        const Stay stay = stay_in_box(solid, rays.x[i], rays.y[i]);
        const bool hit = (stay.enter < stay.leave) & (stay.enter > kNearest);
        depths[i] = hit ? stay.enter : kNothing;
      }
      break;
    case Shape::kRoom:
      for (int i = 0; i < kPack; ++i) {
        const float leave = stay_in_box(solid, rays.x[i], rays.y[i]).leave;
        depths[i] = leave > kNearest ? leave : kNothing;
      }
      break;
    case Shape::kSphere:
      for (int i = 0; i < kPack; ++i) depths[i] = sphere_depth(solid, rays.x[i], rays.y[i]);
      break;
    case Shape::kCylinder:
      for (int i = 0; i < kPack; ++i) depths[i] = cylinder_depth(solid, rays.x[i], rays.y[i]);
      break;
  }
  return depths;
}

// The bounds of the rays that may meet a box: those of its corners, and where an edge dives behind
// the camera, of the point where it does.
void bound(SolidInView& seen, const SE3& camera_from_solid, const Eigen::Vector3d& half) {
  std::array<Eigen::Vector3d, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners[i] = camera_from_solid * Eigen::Vector3d{(i & 1) != 0 ? half.x() : -half.x(),
                                                     (i & 2) != 0 ? half.y() : -half.y(),
                                                     (i & 4) != 0 ? half.z() : -half.z()};
  seen.nearest = kNothing;
  const auto include = [&](const Eigen::Vector3d& point) {
    const Eigen::Vector2d ray = point.head<2>() / point.z();
    seen.bounds.extend(ray.cast<float>());
  };
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d& a = corners[i];
    seen.nearest = std::min(seen.nearest, static_cast<float>(a.z()));
    if (a.z() >= kNearest) include(a);
    for (const int axis : {1, 2, 4}) {
      if ((i & axis) != 0) continue;
      const Eigen::Vector3d& b = corners[i | axis];
      if ((a.z() < kNearest) != (b.z() < kNearest))
        include(a + (kNearest - a.z()) / (b.z() - a.z()) * (b - a));
    }
  }
}

int face_of(const SolidInView& solid, const Eigen::Vector3f& point) {
  if (solid.shape == Shape::kSphere) return kRoundFace;
  if (solid.shape == Shape::kCylinder) {
    const bool on_cap = std::abs(std::abs(point.z()) - solid.half.z()) < 1e-5F;
    return on_cap ? (point.z() < 0 ? 4 : 5) : kRoundFace;
  }
  int axis = 0;
  (point.cwiseAbs() - solid.half).cwiseAbs().minCoeff(&axis);
  return 2 * axis + (point[axis] > 0 ? 1 : 0);
}

}  // namespace

cv::Mat_<cv::Vec2f> make_rays(const DistortedCamera& camera) {
  const Camera& pinhole = camera.pinhole;
  cv::Mat_<cv::Vec2f> rays(pinhole.height + 1, pinhole.width + 1);
  const bool distorted = is_distorted(camera);
  for (int v = 0; v < rays.rows; ++v)
    for (int u = 0; u < rays.cols; ++u) {
      Eigen::Vector2d ray = back_project(pinhole, u, v, 1.0).head<2>();
      if (distorted) ray = undistort(camera, ray);
      rays(v, u) = {static_cast<float>(ray.x()), static_cast<float>(ray.y())};
    }
  return rays;
}

std::vector<SolidInView> view_from(const Scene& scene, double seconds,
                                   const SE3& world_from_camera) {
  std::vector<SolidInView> solids;
  solids.reserve(scene.solids.size());
  for (const Solid& solid : scene.solids) {
    const SE3 solid_from_camera = inverse(pose_at(solid, seconds)) * world_from_camera;
    SolidInView seen{.shape = solid.shape,
                     .half = solid.half,
                     .origin = solid_from_camera.translation.cast<float>(),
                     .rotation = solid_from_camera.rotation.toRotationMatrix().cast<float>(),
                     .bounds = {}};
    bound(seen, inverse(solid_from_camera), solid.half.cast<double>());
    solids.push_back(seen);
  }
  return solids;
}

std::vector<int> nearest_first(std::span<const SolidInView> solids) {
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(solids.size()); ++i)
    if (!solids[i].bounds.isEmpty()) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return solids[a].nearest < solids[b].nearest; });
  return order;
}

std::array<Hit, kPack> cast(std::span<const SolidInView> solids, std::span<const int> candidates,
                            const RayPack& rays) {
  Depths nearest;
  std::array<int, kPack> met;
  nearest.fill(kNothing);
  met.fill(-1);
  for (const int index : candidates) {
    const SolidInView& solid = solids[static_cast<std::size_t>(index)];
    if (solid.nearest > *std::max_element(nearest.begin(), nearest.end())) break;
    const Depths depths = depths_of(solid, rays);
    for (int i = 0; i < kPack; ++i) {
      met[i] = depths[i] < nearest[i] ? index : met[i];
      nearest[i] = std::min(nearest[i], depths[i]);
    }
  }
  std::array<Hit, kPack> hits;
  for (int i = 0; i < kPack; ++i) {
    hits[i] = {.depth = nearest[i], .solid = met[i]};
    if (met[i] < 0) continue;
    const SolidInView& solid = solids[static_cast<std::size_t>(met[i])];
    const Eigen::Vector3f direction = solid.direction(rays.x[i], rays.y[i]);
    hits[i].face = face_of(solid, solid.origin + nearest[i] * direction);
  }
  return hits;
}

}  // namespace edvo::synth
