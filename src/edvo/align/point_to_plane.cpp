// SPDX-License-Identifier: MIT
#include "edvo/align/point_to_plane.hpp"

#include "edvo/align/robust.hpp"
#include "edvo/align/warp.hpp"
#include "edvo/core/lanes.hpp"
#include "edvo/core/simd.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace edvo {
namespace {

constexpr int kProducts = 21;        // of the six columns of the Jacobian
constexpr std::size_t kBlock = 256;  // sums of floats stay short, sums of blocks are double
constexpr float kTukey = 6.F;        // [sigmas] farther off, it is another surface
constexpr float kSaturation = kTukey * kTukey / 6.F;
constexpr double kStale = 1.0;  // [px] pieces of surface are larger

// Which pixel each point projects to, row-major, negative where it is not in warp; and the ray
// through it, z = 1.
EDVO_CLONES void project_loop(const SurfacePoints& surface, const Warp& warp, cv::Size size,
                              DepthAssociations& associations) {
  const auto& [r, t, fx, fy, cx, cy] = warp;
  const float columns = static_cast<float>(size.width), rows = static_cast<float>(size.height);
  for (std::size_t i = 0; i < surface.x.size(); i += kLanes) {
    const Floats& px = lanes(&surface.x[i]);
    const Floats& py = lanes(&surface.y[i]);
    const Floats& pz = lanes(&surface.z[i]);
    const Floats z = r[6] * px + r[7] * py + r[8] * pz + t[2];
    const Floats inverse_z = 1.F / z;
    const Floats u = fx * (r[0] * px + r[1] * py + r[2] * pz + t[0]) * inverse_z + (cx + 0.5F);
    const Floats v = fy * (r[3] * px + r[4] * py + r[5] * pz + t[1]) * inverse_z + (cy + 0.5F);
    const Ints visible =
        (pz > 0.F) & (z > kNearest) & (u >= 0.F) & (v >= 0.F) & (u < columns) & (v < rows);
    const Ints column = __builtin_convertvector(u, Ints) & visible;
    const Ints row = __builtin_convertvector(v, Ints) & visible;
    lanes(&associations.pixels[i]) = (row * size.width + column) | ~visible;
    lanes(&associations.x[i]) = (__builtin_convertvector(column, Floats) - cx) / fx;
    lanes(&associations.y[i]) = (__builtin_convertvector(row, Floats) - cy) / fy;
  }
}

// What a loop over points sums, as floats.
struct Accumulated {
  std::array<float, kProducts> products;  // of the Jacobian's columns, from the diagonal on
  std::array<float, 6> gradient;
  float cost;
};

EDVO_CLONES void sum_loop(const SurfacePoints& surface, const DepthAssociations& associations,
                          const Warp& warp, float noise, float weight, std::size_t first,
                          std::size_t last, Accumulated& out) {
  const auto& r = warp.r;
  const auto& t = warp.t;
  Floats products[kProducts] = {}, gradient[6] = {}, cost = {};
  const Floats zero = {};
  for (std::size_t i = first; i < last; i += kLanes) {
    const Floats& z = lanes(&associations.z[i]);
    const Floats& pz = lanes(&surface.z[i]);
    const Ints real = pz > 0.F, measured = real & (z == z);
    // The seen point, moved to the reference camera.
    const Floats sx = (measured ? lanes(&associations.x[i]) : zero) - t[0];
    const Floats sy = (measured ? lanes(&associations.y[i]) : zero) - t[1];
    const Floats sz = (measured ? z : zero + 1.F) - t[2];
    const Floats x = r[0] * sx + r[3] * sy + r[6] * sz;
    const Floats y = r[1] * sx + r[4] * sy + r[7] * sz;
    const Floats d = r[2] * sx + r[5] * sy + r[8] * sz;
    const Floats& nx = lanes(&surface.nx[i]);
    const Floats& ny = lanes(&surface.ny[i]);
    const Floats& nz = lanes(&surface.nz[i]);
    const Floats residual = nx * x + ny * y + nz * d - 1.F;
    const Floats sigma = noise * (real ? pz : zero + 1.F);
    const Floats inverse_variance = 1.F / (sigma * sigma);
    const Floats square = residual * residual * inverse_variance;
    const Floats left = 1.F - square * (1.F / (kTukey * kTukey));
    const Floats inlier = left > 0.F ? left : zero;  // Tukey's biweight
    const Floats loss = kSaturation * (1.F - inlier * inlier * inlier);
    cost += real ? weight * (measured ? loss : zero + kSaturation) : zero;
    const Floats w = measured ? weight * inlier * inlier * inverse_variance : zero;
    const Floats j[6] = {-nx, -ny, -nz, ny * d - nz * y, nz * x - nx * d, nx * y - ny * x};
    const Floats error = measured ? residual : zero;
    int product = 0;
#pragma GCC unroll 6
    for (int a = 0; a < 6; ++a) {
      const Floats wj = w * j[a];
#pragma GCC unroll 6
      for (int b = a; b < 6; ++b) products[product++] += wj * j[b];
      gradient[a] += wj * error;
    }
  }
  for (std::size_t p = 0; p < kProducts; ++p) out.products[p] = sum_of(products[p]);
  for (std::size_t a = 0; a < 6; ++a) out.gradient[a] = sum_of(gradient[a]);
  out.cost = sum_of(cost);
}

void add(const Accumulated& from, PoseSums& sums) {
  std::size_t product = 0;
  for (int a = 0; a < 6; ++a) {
    for (int b = a; b < 6; ++b) sums.hessian(a, b) += static_cast<double>(from.products[product++]);
    sums.gradient[a] += static_cast<double>(from.gradient[static_cast<std::size_t>(a)]);
  }
  sums.cost += static_cast<double>(from.cost);
}

}  // namespace

bool DepthAssociations::is_stale(const SE3& cur_from_ref, const Camera& camera) const {
  if (!from) return true;
  const SE3 moved = cur_from_ref * inverse(*from);
  return pixels_moved(camera, moved.translation.norm(), rotation_angle(moved)) > kStale;
}

void associate_depth(const SurfacePoints& surface, const Camera& camera, const Depth& depth,
                     const SE3& cur_from_ref, DepthAssociations& associations) {
  const std::size_t count = surface.x.size();
  for (std::vector<float>* array : {&associations.x, &associations.y, &associations.z})
    array->resize(count);
  associations.pixels.resize(count);
  associations.from = cur_from_ref;
  project_loop(surface, make_warp(cur_from_ref, camera), depth.size(), associations);
  depth.look_up(associations.pixels, associations.z);
  for (std::size_t i = 0; i < count; ++i) {
    associations.x[i] *= associations.z[i];
    associations.y[i] *= associations.z[i];
  }
}

PoseSums sum_surface(const SurfacePoints& surface, const DepthAssociations& associations,
                     const SE3& cur_from_ref, float noise, float weight) {
  const Warp warp = make_warp(cur_from_ref, {});
  PoseSums sums;
  Accumulated block;
  for (std::size_t first = 0; first < surface.x.size(); first += kBlock) {
    sum_loop(surface, associations, warp, noise, weight, first,
             std::min(first + kBlock, surface.x.size()), block);
    add(block, sums);
  }
  return sums;
}

float surface_sigma(const SurfacePoints& surface, const DepthAssociations& associations,
                    const SE3& cur_from_ref, std::vector<float>& errors) {
  constexpr std::size_t kEvery = 4;  // points: a median needs no more
  const Eigen::Matrix3f R = cur_from_ref.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = cur_from_ref.translation.cast<float>();
  errors.clear();
  errors.reserve(surface.x.size() / kEvery + 1);
  for (std::size_t i = 0; i < surface.x.size(); i += kEvery) {
    if (!(surface.z[i] > 0)) continue;
    const Eigen::Vector3f x(associations.x[i], associations.y[i],
                            associations.z[i]);  // NaN stays NaN, and is left out
    const Eigen::Vector3f normal(surface.nx[i], surface.ny[i], surface.nz[i]);
    errors.push_back((normal.dot(R.transpose() * (x - t)) - 1.F) / surface.z[i]);
  }
  return mad_sigma(errors);
}

}  // namespace edvo
