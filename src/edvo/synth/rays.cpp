// SPDX-License-Identifier: MIT
#include "edvo/synth/rays.hpp"

#include <cmath>
#include <limits>

namespace edvo::synth {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr float kNearest = 0.01F;  // a camera sees nothing closer [m]

Eigen::Vector2d distort(const std::array<double, 5>& k, const Eigen::Vector2d& ray) {
  const double x = ray.x(), y = ray.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

// Newton's method with numeric derivatives; lens distortion is nearly the identity.
Eigen::Vector2d undistort(const std::array<double, 5>& k, const Eigen::Vector2d& distorted) {
  constexpr int kSteps = 12;
  constexpr double kDelta = 1e-6;
  Eigen::Vector2d ray = distorted;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector2d error = distort(k, ray) - distorted;
    if (error.norm() < 1e-12) break;
    Eigen::Matrix2d J;
    J.col(0) = (distort(k, ray + Eigen::Vector2d{kDelta, 0}) -
                distort(k, ray - Eigen::Vector2d{kDelta, 0})) /
               (2 * kDelta);
    J.col(1) = (distort(k, ray + Eigen::Vector2d{0, kDelta}) -
                distort(k, ray - Eigen::Vector2d{0, kDelta})) /
               (2 * kDelta);
    ray -= J.inverse() * error;
  }
  return ray;
}

Eigen::Array4f lanes(const Eigen::Vector3d& v, float fourth) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()), fourth};
}

// Parameters at which a ray enters and leaves a slab-bounded box.
struct Span {
  float enter = 0, leave = 0;
};

// A direction of exactly zero would make 0/0 of a ray inside a face's plane.
Eigen::Array4f inverse_of(const Eigen::Array4f& direction) {
  constexpr float kTiny = 1e-20F;
  return (direction.abs() < kTiny).select(Eigen::Array4f::Constant(1 / kTiny), direction.inverse());
}

Span box_span(const SolidInView& solid, const Eigen::Array4f& direction) {
  const Eigen::Array4f slope = inverse_of(direction);
  const Eigen::Array4f a = (-solid.half - solid.origin) * slope;
  const Eigen::Array4f b = (solid.half - solid.origin) * slope;
  return {.enter = a.min(b).maxCoeff(), .leave = a.max(b).minCoeff()};
}

// Nearer root of |o + t d|^2 = r^2 in the plane or in space.
float round_depth(float dd, float od, float oo_minus_rr) {
  const float discriminant = od * od - dd * oo_minus_rr;
  if (discriminant < 0) return kNothing;
  const float t = (-od - std::sqrt(discriminant)) / dd;
  return t > kNearest ? t : kNothing;
}

float cylinder_depth(const SolidInView& solid, const Eigen::Array4f& d) {
  const Eigen::Array4f& o = solid.origin;
  const float radius = solid.half[0], height = solid.half[2];
  const float side = round_depth(d[0] * d[0] + d[1] * d[1], o[0] * d[0] + o[1] * d[1],
                                 o[0] * o[0] + o[1] * o[1] - radius * radius);
  if (side < kNothing && std::abs(o[2] + side * d[2]) <= height) return side;
  const float cap = ((d[2] < 0 ? height : -height) - o[2]) / d[2];
  const float x = o[0] + cap * d[0], y = o[1] + cap * d[1];
  return cap > kNearest && x * x + y * y <= radius * radius ? cap : kNothing;
}

float sphere_depth(const SolidInView& solid, const Eigen::Array4f& d) {
  const auto dot3 = [](const Eigen::Array4f& a, const Eigen::Array4f& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  return round_depth(dot3(d, d), dot3(solid.origin, d),
                     dot3(solid.origin, solid.origin) - solid.half[0] * solid.half[0]);
}

float depth_of(const SolidInView& solid, const Eigen::Array4f& direction) {
  switch (solid.shape) {
    case Shape::kBox: {
      const Span span = box_span(solid, direction);
      return span.enter < span.leave && span.enter > kNearest ? span.enter : kNothing;
    }
    case Shape::kRoom: {
      const float leave = box_span(solid, direction).leave;
      return leave > kNearest ? leave : kNothing;
    }
    case Shape::kSphere:
      return sphere_depth(solid, direction);
    case Shape::kCylinder:
      return cylinder_depth(solid, direction);
  }
  return kNothing;
}

int face_of(const SolidInView& solid, const Eigen::Array4f& direction, float depth) {
  if (solid.shape == Shape::kSphere) return kRoundFace;
  const Eigen::Array4f point = solid.origin + direction * depth;
  if (solid.shape == Shape::kCylinder) {
    const bool on_cap = std::abs(std::abs(point[2]) - solid.half[2]) < 1e-5F;
    return on_cap ? (point[2] < 0 ? 4 : 5) : kRoundFace;
  }
  int axis = 0;
  const Eigen::Array4f gap = (point.abs() - solid.half).abs();
  for (int i = 1; i < 3; ++i)
    if (gap[i] < gap[axis]) axis = i;
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
      if (distorted) ray = undistort(camera.distortion, ray);
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
    const Eigen::Matrix3d R = solid_from_camera.rotation.toRotationMatrix();
    const float radius = solid.shape == Shape::kSphere ? solid.half.x() : solid.half.norm();
    solids.push_back({.shape = solid.shape,
                      .origin = lanes(solid_from_camera.translation, 0),
                      .x = lanes(R.col(0), 0),
                      .y = lanes(R.col(1), 0),
                      .z = lanes(R.col(2), 1),
                      .half = lanes(solid.half.cast<double>(), 1e9F),
                      .centre = inverse(solid_from_camera).translation.cast<float>(),
                      .radius = radius});
  }
  return solids;
}

Hit cast(std::span<const SolidInView> solids, std::span<const int> candidates, float ray_x,
         float ray_y) {
  Hit hit{.depth = kNothing};
  for (const int index : candidates) {
    const SolidInView& solid = solids[static_cast<std::size_t>(index)];
    const float depth = depth_of(solid, solid.direction(ray_x, ray_y));
    if (depth < hit.depth) {
      hit.depth = depth;
      hit.solid = index;
    }
  }
  if (hit.solid >= 0) {
    const SolidInView& solid = solids[static_cast<std::size_t>(hit.solid)];
    hit.face = face_of(solid, solid.direction(ray_x, ray_y), hit.depth);
  }
  return hit;
}

}  // namespace edvo::synth
