// SPDX-License-Identifier: MIT
#include "edvo/synth/render.hpp"

#include "edvo/synth/parallel.hpp"
#include "edvo/synth/rays.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace edvo::synth {
namespace {

constexpr int kTile = 16;  // [px]

// A pixel gathers light from a square of this side: lens and colour mosaic blur about as much.
constexpr float kPixelFootprint = 1.5F;  // [px]

struct Offset {
  float x = 0, y = 0;  // [px]
};

// Inside one face: four samples on a turned grid. Across edges: eight, no two of which share a row
// or a column, so that coverage of an edge grows in steps of an eighth whatever its direction.
constexpr std::array<Offset, 4> kInnerSamples = {
    {{-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}}};
constexpr std::array<Offset, 8> kEdgeSamples = {{{-0.4375F, -0.0625F},
                                                 {-0.3125F, 0.3125F},
                                                 {-0.1875F, -0.3125F},
                                                 {-0.0625F, 0.0625F},
                                                 {0.0625F, 0.4375F},
                                                 {0.1875F, -0.4375F},
                                                 {0.3125F, 0.1875F},
                                                 {0.4375F, -0.1875F}}};

// All that is needed to colour a pixel.
struct View {
  const Scene& scene;
  const cv::Mat_<cv::Vec2f>& rays;
  std::vector<SolidInView> solids;
  std::vector<Eigen::Vector3f> lights;  // the lamp in the frame of each solid [m]
  float pixel_angle = 0;                // [rad]
};

struct SurfacePoint {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // in the frame of the solid [m]
  float u = 0, v = 0;  // on the face [m], or [tiles] if it bears one tile
  int material = 0;
};

Offset ray_at(const View& view, int x, int y, const Offset& offset) {
  const cv::Vec2f& centre = view.rays(y, x);
  const cv::Vec2f right = view.rays(y, x + 1) - centre;
  const cv::Vec2f down = view.rays(y + 1, x) - centre;
  const float a = offset.x * kPixelFootprint, b = offset.y * kPixelFootprint;
  return {centre[0] + a * right[0] + b * down[0], centre[1] + a * right[1] + b * down[1]};
}

// Coordinates on a surface run from a corner of the face, so that one tile can span it.
SurfacePoint on_surface(const Solid& solid, const Eigen::Vector3f& point, int face) {
  SurfacePoint surface;
  surface.point = point;
  if (face != kRoundFace) {
    const int axis = face / 2;
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    surface.normal[axis] = face % 2 == 1 ? 1.0F : -1.0F;
    if (solid.shape == Shape::kRoom) surface.normal = -surface.normal;
    surface.u = point[u] + solid.half[u];
    surface.v = v == 2 ? solid.half[v] - point[v] : point[v] + solid.half[v];
  } else {
    const bool ball = solid.shape == Shape::kSphere;
    surface.normal = (ball ? point : Eigen::Vector3f(point.x(), point.y(), 0)).normalized();
    surface.u = solid.half.x() * std::atan2(point.y(), point.x());
    surface.v =
        ball ? solid.half.x() * std::asin(std::clamp(surface.normal.z(), -1.0F, 1.0F)) : point.z();
  }
  surface.material =
      solid.materials[solid.shape == Shape::kSphere || solid.shape == Shape::kCylinder ? 0 : face];
  return surface;
}

// Tile size on a face: given by the material, or the face itself.
Eigen::Vector2f tile_size(const Solid& solid, const Material& material, int face) {
  if (material.tile.x() > 0) return material.tile;
  if (face == kRoundFace) {
    const auto round = static_cast<float>(2 * std::numbers::pi) * solid.half.x();
    return {round, solid.shape == Shape::kSphere ? round / 2 : 2 * solid.half.z()};
  }
  const int axis = face / 2;
  return {2 * solid.half[axis == 0 ? 1 : 0], 2 * solid.half[axis == 2 ? 1 : 2]};
}

// Ambient light that tells directions apart, plus the lamp: creases show on plain surfaces too.
float brightness(const Eigen::Vector3f& point, const Eigen::Vector3f& normal,
                 const Eigen::Vector3f& light) {
  const Eigen::Vector3f to_light = light - point;
  const float distance2 = to_light.squaredNorm();
  const float lambert = std::max(0.0F, normal.dot(to_light) / std::sqrt(distance2));
  const float ambient = 0.5F + 0.06F * normal.z() + 0.05F * normal.x() + 0.03F * normal.y();
  return ambient + 0.6F * lambert / (1 + 0.06F * distance2);
}

// Texture level at which one texel covers one sample: the mean square of the footprint's two axes,
// the longer of which grows with the slant.
float lod_of(float depth, float incidence, float angle, float texels_per_metre) {
  const float side = depth * angle * texels_per_metre;
  const float slant = std::max(incidence, 0.05F);
  return 0.5F * std::log2(std::max(0.5F * side * side * (1 + 1 / (slant * slant)), 1e-6F));
}

struct Sample {
  cv::Vec3f bgr;
  float incidence = 0;
};

float incidence_of(const Eigen::Vector3f& normal, const Eigen::Vector3f& direction) {
  return std::min(1.0F, std::abs(normal.dot(direction)) / direction.norm());
}

cv::Vec3f colour_of(const Material& material, float value, float light) {
  const Eigen::Vector3f bgr = light * (material.dark + value * (material.bright - material.dark));
  return {bgr.x(), bgr.y(), bgr.z()};
}

// One ray of its own, for pixels on edges and round solids.
Sample shade_ray(const View& view, const Hit& hit, const Offset& ray, float sample_angle) {
  const SolidInView& seen = view.solids[hit.solid];
  const Solid& solid = view.scene.solids[hit.solid];
  const Eigen::Vector3f direction = seen.direction(ray.x, ray.y).head<3>();
  const Eigen::Vector3f point = seen.origin.head<3>().matrix() + hit.depth * direction;
  const SurfacePoint surface = on_surface(solid, point, hit.face);
  const Material& material = view.scene.materials[surface.material];
  const Texture& texture = view.scene.textures[material.texture];
  const Eigen::Vector2f tile = tile_size(solid, material, hit.face);
  const float incidence = incidence_of(surface.normal, direction);
  const float texels = static_cast<float>(texture.levels.front().size) / tile.minCoeff();
  const float value = sample(texture, surface.u / tile.x(), surface.v / tile.y(),
                             lod_of(hit.depth, incidence, sample_angle, texels));
  const float light = brightness(point, surface.normal, view.lights[hit.solid]);
  return {.bgr = colour_of(material, value, light), .incidence = incidence};
}

// A pixel whose neighbours all lie on the same flat face: the texture is sampled four times, the
// rest once.
Sample shade_flat(const View& view, const Hit& hit, int x, int y) {
  const SolidInView& seen = view.solids[hit.solid];
  const Solid& solid = view.scene.solids[hit.solid];
  const int axis = hit.face / 2;
  const float plane = (hit.face % 2 == 1 ? 1.0F : -1.0F) * solid.half[axis];
  const auto point_at = [&](const Offset& ray) -> Eigen::Vector3f {
    const Eigen::Array4f direction = seen.direction(ray.x, ray.y);
    const float depth = (plane - seen.origin[axis]) / direction[axis];
    return (seen.origin + depth * direction).head<3>();
  };
  const Offset ray = ray_at(view, x, y, {});
  const Eigen::Vector3f direction = seen.direction(ray.x, ray.y).head<3>();
  const SurfacePoint centre = on_surface(solid, point_at(ray), hit.face);
  const Material& material = view.scene.materials[centre.material];
  const Texture& texture = view.scene.textures[material.texture];
  const Eigen::Vector2f tile = tile_size(solid, material, hit.face);
  const float incidence = incidence_of(centre.normal, direction);
  const float texels = static_cast<float>(texture.levels.front().size) / tile.minCoeff();
  const float lod = lod_of(hit.depth, incidence, 0.5F * kPixelFootprint * view.pixel_angle, texels);
  float value = 0;
  for (const Offset& offset : kInnerSamples) {
    const SurfacePoint surface = on_surface(solid, point_at(ray_at(view, x, y, offset)), hit.face);
    value += sample(texture, surface.u / tile.x(), surface.v / tile.y(), lod);
  }
  const float light = brightness(centre.point, centre.normal, view.lights[hit.solid]);
  return {.bgr = colour_of(material, value / kInnerSamples.size(), light), .incidence = incidence};
}

Sample shade_edge(const View& view, std::span<const int> candidates, const Hit& hit, int x, int y) {
  const float angle =
      kPixelFootprint * view.pixel_angle / std::sqrt(static_cast<float>(kEdgeSamples.size()));
  Sample result = shade_ray(view, hit, ray_at(view, x, y, {}), angle);
  result.bgr = {};
  for (const Offset& offset : kEdgeSamples) {
    const Offset ray = ray_at(view, x, y, offset);
    const Hit near = cast(view.solids, candidates, ray.x, ray.y);
    if (near.solid >= 0) result.bgr += shade_ray(view, near, ray, angle).bgr;
  }
  result.bgr *= 1.0F / static_cast<float>(kEdgeSamples.size());
  return result;
}

// The solids that a cone around a tile of pixels may meet. Border samples reach half a footprint
// out.
std::vector<int> candidates_in(const View& view, const cv::Rect& tile) {
  const auto direction = [&](int x, int y) {
    const cv::Vec2f& ray =
        view.rays(std::clamp(y, 0, view.rays.rows - 1), std::clamp(x, 0, view.rays.cols - 1));
    return Eigen::Vector3f(ray[0], ray[1], 1).normalized();
  };
  const Eigen::Vector3f axis = direction(tile.x + tile.width / 2, tile.y + tile.height / 2);
  float cosine = 1;
  for (const int x : {tile.x - 1, tile.x + tile.width})
    for (const int y : {tile.y - 1, tile.y + tile.height})
      cosine = std::min(cosine, axis.dot(direction(x, y)));
  const float half_angle = std::acos(std::min(cosine, 1.0F)) + view.pixel_angle;
  std::vector<int> candidates;
  for (int i = 0; i < static_cast<int>(view.solids.size()); ++i) {
    const SolidInView& solid = view.solids[i];
    const float distance = solid.centre.norm();
    if (distance > solid.radius) {
      const float reach = half_angle + std::asin(solid.radius / distance);
      if (reach < 3 && axis.dot(solid.centre) < distance * std::cos(reach)) continue;
    }
    candidates.push_back(i);
  }
  return candidates;
}

int surface_id(const Hit& hit) {
  return hit.solid * 8 + hit.face;
}

// Flat inside, and all eight neighbours on the same face.
bool is_inner(const cv::Mat_<int>& ids, int x, int y) {
  const int id = ids(y, x);
  if (id % 8 == kRoundFace) return false;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int nx = std::clamp(x + dx, 0, ids.cols - 1), ny = std::clamp(y + dy, 0, ids.rows - 1);
      if (ids(ny, nx) != id) return false;
    }
  return true;
}

View make_view(const Scene& scene, double seconds, const SE3& world_from_camera,
               const cv::Mat_<cv::Vec2f>& rays) {
  View view{.scene = scene,
            .rays = rays,
            .solids = view_from(scene, seconds, world_from_camera),
            .lights = {}};
  for (const Solid& solid : scene.solids)
    view.lights.push_back(
        (inverse(pose_at(solid, seconds)) * scene.light.cast<double>()).cast<float>());
  const int x = rays.cols / 2, y = rays.rows / 2;
  view.pixel_angle = static_cast<float>(cv::norm(rays(y, x + 1) - rays(y, x)));
  return view;
}

}  // namespace

Render render(const Scene& scene, double seconds, const SE3& world_from_camera,
              const cv::Mat_<cv::Vec2f>& rays, int threads) {
  const View view = make_view(scene, seconds, world_from_camera, rays);
  const int width = rays.cols - 1, height = rays.rows - 1;
  const int tiles_x = (width + kTile - 1) / kTile, tiles_y = (height + kTile - 1) / kTile;
  Render image{.bgr = cv::Mat_<cv::Vec3f>(height, width, cv::Vec3f::all(0)),
               .depth = cv::Mat_<float>(height, width),
               .incidence = cv::Mat_<float>(height, width, 0.0F)};
  cv::Mat_<int> ids(height, width);
  std::vector<std::vector<int>> candidates(static_cast<std::size_t>(tiles_x * tiles_y));

  const auto for_each_pixel = [&](const auto& function) {
    for_each_block(tiles_y, threads, [&](int row) {
      for (int column = 0; column < tiles_x; ++column) {
        const cv::Rect tile =
            cv::Rect(column * kTile, row * kTile, kTile, kTile) & cv::Rect(0, 0, width, height);
        function(tile, candidates[static_cast<std::size_t>(row * tiles_x + column)]);
      }
    });
  };
  for_each_pixel([&](const cv::Rect& tile, std::vector<int>& nearby) {
    nearby = candidates_in(view, tile);
    for (int y = tile.y; y < tile.y + tile.height; ++y)
      for (int x = tile.x; x < tile.x + tile.width; ++x) {
        const Hit hit = cast(view.solids, nearby, rays(y, x)[0], rays(y, x)[1]);
        image.depth(y, x) = hit.solid < 0 ? std::numeric_limits<float>::quiet_NaN() : hit.depth;
        ids(y, x) = surface_id(hit);
      }
  });
  for_each_pixel([&](const cv::Rect& tile, const std::vector<int>& nearby) {
    for (int y = tile.y; y < tile.y + tile.height; ++y)
      for (int x = tile.x; x < tile.x + tile.width; ++x) {
        const int id = ids(y, x);
        if (id < 0) continue;
        const Hit hit{.depth = image.depth(y, x), .solid = id / 8, .face = id % 8};
        const Sample sample =
            is_inner(ids, x, y) ? shade_flat(view, hit, x, y) : shade_edge(view, nearby, hit, x, y);
        image.bgr(y, x) = sample.bgr;
        image.incidence(y, x) = sample.incidence;
      }
  });
  return image;
}

}  // namespace edvo::synth
