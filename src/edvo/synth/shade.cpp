// SPDX-License-Identifier: MIT
#include "edvo/synth/shade.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace edvo::synth {
namespace {

// A pixel gathers light from a square of this side: lens and colour mosaic blur about as much.
constexpr float kPixelFootprint = 1.5F;  // [px]

// Inside one face: four samples on a turned grid. Across edges: a pack of eight, no two of which
// share a row or a column, so that coverage of an edge grows in steps of an eighth at any slant.
const Eigen::Array4f kInnerX = kPixelFootprint * Eigen::Array4f{-0.125F, 0.375F, -0.375F, 0.125F};
const Eigen::Array4f kInnerY = kPixelFootprint * Eigen::Array4f{-0.375F, -0.125F, 0.125F, 0.375F};
constexpr std::array<float, kPack> kEdgeX = {-7, -5, -3, -1, 1, 3, 5, 7};  // [footprint/16]
constexpr std::array<float, kPack> kEdgeY = {-1, 5, -5, 1, 7, -7, 3, -3};

// Rays across a pixel: ray = centre + a * right + b * down, a and b in [px].
struct PixelRays {
  cv::Vec2f centre, right, down;
};

PixelRays rays_of(const View& view, int x, int y) {
  const cv::Vec2f& centre = view.rays(y, x);
  return {centre, view.rays(y, x + 1) - centre, view.rays(y + 1, x) - centre};
}

FacePaint paint_of(const Scene& scene, const Solid& solid, int face) {
  const bool round = face == kRoundFace, ball = solid.shape == Shape::kSphere;
  const bool painted_once = round || ball || solid.shape == Shape::kCylinder;
  const Material& material = scene.materials[solid.materials[painted_once ? 0 : face]];
  FacePaint paint{.texture = material.texture,
                  .dark = material.dark,
                  .bright = material.bright - material.dark};
  Eigen::Array2f size;  // of the face [m]
  if (round) {
    const float girth = static_cast<float>(2 * std::numbers::pi) * solid.half.x();
    size = {girth, ball ? girth / 2 : 2 * solid.half.z()};
  } else {
    paint.axis = face / 2;
    paint.u = paint.axis == 0 ? 1 : 0;
    paint.v = paint.axis == 2 ? 1 : 2;
    const float side = face % 2 == 1 ? 1.0F : -1.0F;
    paint.plane = side * solid.half[paint.axis];
    paint.normal[paint.axis] = solid.shape == Shape::kRoom ? -side : side;
    size = {2 * solid.half[paint.u], 2 * solid.half[paint.v]};
  }
  const Eigen::Array2f tile = material.tile.x() > 0 ? material.tile.array() : size;
  const auto texture_size = static_cast<float>(scene.textures[paint.texture].levels.front().size);
  paint.texels = texture_size / tile.minCoeff();
  paint.tiles = tile.inverse();
  if (paint.v == 2) paint.tiles[1] = -paint.tiles[1];  // rows of a picture run down
  paint.first_tile = 0.5F * size / tile;               // tiles begin at a corner
  return paint;
}

// Ambient light that tells directions apart, plus the lamp: creases show on plain surfaces too.
// point, normal: in the frame of the solid.
float brightness(const View& view, int solid, const Eigen::Vector3f& point,
                 const Eigen::Vector3f& normal) {
  const Eigen::Vector3f& light = view.lights[solid];
  const Eigen::Vector3f to_light = light - point;
  const float distance2 = to_light.squaredNorm();
  float lambert = std::max(0.0F, normal.dot(to_light) / std::sqrt(distance2));
  if (lambert > 0 && !view.casters.empty())
    lambert *= lamp_share(view.casters, solid, view.world_from_solids[solid] * point, view.lamp);
  const float ambient = 0.5F + 0.06F * normal.z() + 0.05F * normal.x() + 0.03F * normal.y();
  return ambient + 0.6F * lambert / (1 + 0.06F * distance2);
}

// Texture level at which one texel covers one sample: the mean square of the footprint's two axes,
// the longer of which grows with the slant.
float lod_of(float depth, float incidence, float angle, float texels) {
  const float side = depth * angle * texels;
  const float slant = std::max(incidence, 0.05F);
  return 0.5F * std::log2(std::max(0.5F * side * side * (1 + 1 / (slant * slant)), 1e-6F));
}

float incidence_of(const Eigen::Vector3f& normal, const Eigen::Vector3f& direction) {
  return std::min(1.0F, std::abs(normal.dot(direction)) / direction.norm());
}

cv::Vec3f colour_of(const FacePaint& paint, float value, float light) {
  const Eigen::Vector3f bgr = light * (paint.dark + value * paint.bright);
  return {bgr.x(), bgr.y(), bgr.z()};
}

// One ray's colour.
Shade shade_ray(const View& view, const Hit& hit, float ray_x, float ray_y, float sample_angle) {
  const SolidInView& seen = view.solids[hit.solid];
  const FacePaint& paint = view.paints[hit.solid][hit.face];
  const Eigen::Vector3f direction = seen.direction(ray_x, ray_y);
  const Eigen::Vector3f point = seen.origin + hit.depth * direction;
  Eigen::Vector3f normal = paint.normal;
  Eigen::Array2f on_face{point[paint.u], point[paint.v]};  // [m]
  if (hit.face == kRoundFace) {
    const bool ball = seen.shape == Shape::kSphere;
    normal = Eigen::Vector3f(point.x(), point.y(), ball ? point.z() : 0.0F).normalized();
    on_face = {seen.half[0] * std::atan2(point.y(), point.x()),
               ball ? seen.half[0] * std::asin(std::clamp(normal.z(), -1.0F, 1.0F)) : point.z()};
  }
  const float incidence = incidence_of(normal, direction);
  const Eigen::Array2f tile = on_face * paint.tiles + paint.first_tile;
  const float value = sample(view.scene.textures[paint.texture], tile[0], tile[1],
                             lod_of(hit.depth, incidence, sample_angle, paint.texels));
  const float light = brightness(view, hit.solid, point, normal);
  return {.bgr = colour_of(paint, value, light), .incidence = incidence};
}

}  // namespace

View make_warp(const Scene& scene, double seconds, const SE3& world_from_camera,
               const cv::Mat_<cv::Vec2f>& rays) {
  View view{.scene = scene,
            .rays = rays,
            .solids = view_from(scene, seconds, world_from_camera),
            .order = {},
            .paints = {},
            .lights = {},
            .casters = scene.shadows ? casters_of(scene, seconds) : std::vector<Caster>{},
            .world_from_solids = {},
            .lamp = lamp_at(scene, seconds)};
  view.order = nearest_first(view.solids);
  for (const Solid& solid : scene.solids) {
    const SE3 world_from_solid = pose_at(solid, seconds);
    const Eigen::Isometry3d isometry =
        Eigen::Translation3d(world_from_solid.translation) * world_from_solid.rotation;
    view.world_from_solids.push_back(isometry.cast<float>());
    view.lights.push_back((inverse(world_from_solid) * view.lamp.cast<double>()).cast<float>());
    std::array<FacePaint, 7> paints;
    for (int face = 0; face < 7; ++face) paints[face] = paint_of(scene, solid, face);
    view.paints.push_back(paints);
  }
  const int x = rays.cols / 2, y = rays.rows / 2;
  view.pixel_angle = static_cast<float>(cv::norm(rays(y, x + 1) - rays(y, x)));
  return view;
}

Shade shade_flat(const View& view, const Hit& hit, int x, int y) {
  constexpr float kSampleSide = 0.5F * kPixelFootprint;  // [px]
  const SolidInView& seen = view.solids[hit.solid];
  const FacePaint& paint = view.paints[hit.solid][hit.face];
  const PixelRays rays = rays_of(view, x, y);
  const Eigen::Vector3f direction = seen.direction(rays.centre[0], rays.centre[1]);
  const Eigen::Vector3f right =
      seen.rotation.leftCols<2>() * Eigen::Vector2f(rays.right[0], rays.right[1]);
  const Eigen::Vector3f down =
      seen.rotation.leftCols<2>() * Eigen::Vector2f(rays.down[0], rays.down[1]);
  const auto along = [&](int axis) -> Eigen::Array4f {
    return direction[axis] + kInnerX * right[axis] + kInnerY * down[axis];
  };
  const Eigen::Array4f depth = (paint.plane - seen.origin[paint.axis]) / along(paint.axis);
  const Eigen::Array4f u = seen.origin[paint.u] + depth * along(paint.u);
  const Eigen::Array4f v = seen.origin[paint.v] + depth * along(paint.v);

  const Eigen::Vector3f point = seen.origin + hit.depth * direction;
  const float incidence = incidence_of(paint.normal, direction);
  const float value =
      mean_of_four(view.scene.textures[paint.texture], u * paint.tiles[0] + paint.first_tile[0],
                   v * paint.tiles[1] + paint.first_tile[1],
                   lod_of(hit.depth, incidence, kSampleSide * view.pixel_angle, paint.texels));
  const float light = brightness(view, hit.solid, point, paint.normal);
  return {.bgr = colour_of(paint, value, light), .incidence = incidence};
}

Shade shade_edge(const View& view, std::span<const int> candidates, const Hit& hit, int x, int y) {
  const float angle = kPixelFootprint * view.pixel_angle / std::sqrt(static_cast<float>(kPack));
  const PixelRays rays = rays_of(view, x, y);
  Shade result{.bgr = {0, 0, 0},
               .incidence = shade_ray(view, hit, rays.centre[0], rays.centre[1], angle).incidence};
  RayPack pack;
  for (int i = 0; i < kPack; ++i) {
    const float a = kPixelFootprint / 16 * kEdgeX[i], b = kPixelFootprint / 16 * kEdgeY[i];
    const cv::Vec2f ray = rays.centre + a * rays.right + b * rays.down;
    pack.x[i] = ray[0];
    pack.y[i] = ray[1];
  }
  const std::array<Hit, kPack> hits = cast(view.solids, candidates, pack);
  for (int i = 0; i < kPack; ++i)
    if (hits[i].solid >= 0) result.bgr += shade_ray(view, hits[i], pack.x[i], pack.y[i], angle).bgr;
  result.bgr *= 1.0F / kPack;
  return result;
}

}  // namespace edvo::synth
