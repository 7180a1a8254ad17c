// SPDX-License-Identifier: MIT
#include "edvo/align/surface.hpp"

#include "edvo/simd/float8.hpp"

#include <cmath>
#include <utility>

namespace edvo {
namespace {

constexpr float kFlatSigmas = 4.F;  // a sample farther from the plane: the piece is not flat

// Inverse depth of a plane is linear in the pixel: rho = a (u - u0) + b (v - v0) + c.
struct Plane {
  float a = 0, b = 0, c = 0;
};

// Fit to 3 x 3 samples `step` apart; false where one is missing or off the plane.
bool fit(const Depth& depth, int u, int v, int step, float noise, Plane& plane) {
  float rho[3][3];
  float sum = 0;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      sum += rho[j][i] = 1.F / depth(v + (j - 1) * step, u + (i - 1) * step);
  if (!std::isfinite(sum)) return false;
  const float width = 6.F * static_cast<float>(step);
  plane.a = (rho[0][2] + rho[1][2] + rho[2][2] - rho[0][0] - rho[1][0] - rho[2][0]) / width;
  plane.b = (rho[2][0] + rho[2][1] + rho[2][2] - rho[0][0] - rho[0][1] - rho[0][2]) / width;
  plane.c = sum / 9.F;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const float du = static_cast<float>((i - 1) * step), dv = static_cast<float>((j - 1) * step);
      if (std::abs(rho[j][i] - (plane.a * du + plane.b * dv + plane.c)) > kFlatSigmas * noise)
        return false;
    }
  return true;
}

}  // namespace

void SurfacePoints::clear() {
  for (std::vector<float>* array : {&x, &y, &z, &nx, &ny, &nz}) array->clear();
}

SurfacePoints make_surface(const Depth& depth, const Camera& camera, int cell, double noise,
                           SurfacePoints recycled) {
  SurfacePoints surface = std::move(recycled);
  surface.clear();
  const int step = std::max(1, cell / 3);
  const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const float cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  for (int v = step; v + step < depth.rows(); v += cell)
    for (int u = step; u + step < depth.cols(); u += cell) {
      Plane plane;
      if (!fit(depth, u, v, step, static_cast<float>(noise), plane)) continue;
      const float z = 1.F / plane.c;
      const float x = (static_cast<float>(u) - cx) / fx, y = (static_cast<float>(v) - cy) / fy;
      surface.x.push_back(x * z);
      surface.y.push_back(y * z);
      surface.z.push_back(z);
      // 1 = z rho and u = fx X / Z + cx make the plane  a fx X + b fy Y + (c - a fx x - b fy y) Z
      // = 1.
      surface.nx.push_back(plane.a * fx);
      surface.ny.push_back(plane.b * fy);
      surface.nz.push_back(plane.c - plane.a * fx * x - plane.b * fy * y);
    }
  const std::size_t length = simd::padded(surface.x.size());
  for (std::vector<float>* array :
       {&surface.x, &surface.y, &surface.z, &surface.nx, &surface.ny, &surface.nz})
    array->resize(length);
  return surface;
}

}  // namespace edvo
