// SPDX-License-Identifier: MIT
#include "edvo/track/reference.hpp"

#include "edvo/core/lanes.hpp"
#include "edvo/track/bilinear.hpp"

#include <utility>

namespace edvo {
namespace {

// d (u, v) / d xi for a point moved by exp(xi), contracted with the image gradient (gx, gy) [1 /
// px].
std::array<float, 6> intensity_jacobian(const Camera& camera, const Eigen::Vector3f& p, float gx,
                                        float gy) {
  const float inverse_z = 1.F / p.z();
  const float a = gx * static_cast<float>(camera.fx) * inverse_z;
  const float b = gy * static_cast<float>(camera.fy) * inverse_z;
  const float c = -(a * p.x() + b * p.y()) * inverse_z;
  // rho: (a, b, c); phi: p x (a, b, c), because d(exp(xi) p) / d phi = -[p]x.
  return {a, b, c, p.y() * c - p.z() * b, p.z() * a - p.x() * c, p.x() * b - p.y() * a};
}

void clear(ReferenceLevel& level) {
  level.count = 0;
  for (std::vector<float>* array : {&level.x, &level.y, &level.z, &level.intensity, &level.weight})
    array->clear();
  for (std::vector<float>& array : level.jacobian) array.clear();
}

}  // namespace

Reference make_reference(const Frame& frame, const std::vector<SelectedPixel>& pixels,
                         const ReferenceOptions& options, Reference recycled) {
  Reference reference = std::move(recycled);
  reference.levels.resize(frame.levels.size());
  reference.surface.clear();
  reference.edge_points.clear();
  const Camera& full = frame.levels.front().camera;
  for (std::size_t l = 0; l < frame.levels.size(); ++l) {
    const Level& source = frame.levels[l];
    const float scale = 1.F / static_cast<float>(1 << l);
    const float softness_squared = static_cast<float>(options.softness * options.softness);
    ReferenceLevel& level = reference.levels[l];
    level.camera = source.camera;
    clear(level);
    if (static_cast<int>(l) < options.finest_level || static_cast<int>(l) > options.coarsest_level)
      continue;
    for (const SelectedPixel& selected : pixels) {
      const float u = static_cast<float>(selected.pixel.x) * scale;
      const float v = static_cast<float>(selected.pixel.y) * scale;
      if (!inside(source.gray, u, v, 1)) continue;
      const Eigen::Vector3f p =
          back_project(full, selected.pixel.x, selected.pixel.y, selected.depth).cast<float>();
      const float gx = 0.5F * (bilinear(source.gray, u + 1, v) - bilinear(source.gray, u - 1, v));
      const float gy = 0.5F * (bilinear(source.gray, u, v + 1) - bilinear(source.gray, u, v - 1));
      level.x.push_back(p.x());
      level.y.push_back(p.y());
      level.z.push_back(p.z());
      level.intensity.push_back(bilinear(source.gray, u, v));
      level.weight.push_back(softness_squared / (softness_squared + gx * gx + gy * gy));
      const std::array<float, 6> J = intensity_jacobian(source.camera, p, gx, gy);
      for (std::size_t k = 0; k < 6; ++k) level.jacobian[k].push_back(J[k]);
    }
    level.count = level.x.size();
    const std::size_t length = padded(level.count);
    for (std::vector<float>* array :
         {&level.x, &level.y, &level.z, &level.intensity, &level.weight})
      array->resize(length);
    for (std::vector<float>& array : level.jacobian) array.resize(length);
  }
  return reference;
}

}  // namespace edvo
