// SPDX-License-Identifier: MIT
#include "edvo/align/point_to_plane.hpp"

#include "edvo/align/robust.hpp"
#include "edvo/align/warp.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

constexpr int kProducts = 21;        // of the six columns of the Jacobian
constexpr std::size_t kBlock = 256;  // sums of floats stay short, sums of blocks are double
constexpr float kTukey = 6.F;        // [sigmas] farther off, it is another surface
constexpr float kSaturation = kTukey * kTukey / 6.F;
constexpr double kStale = 1.0;  // [px] pieces of surface are larger

// Which pixel each point projects to, row-major, negative where it is not in warp; and the ray
// through it, z = 1.
EDVO_CLONES void project_loop(const SurfacePoints& surface, const Warp& warp, cv::Size size,
                              DepthAssociations& associations) {
  const auto& [r, t] = warp.motion;
  const auto& [fx, fy, cx, cy] = warp.camera;
  const float columns = static_cast<float>(size.width), rows = static_cast<float>(size.height);
  for (std::size_t i = 0; i < surface.x.size(); i += simd::kWidth) {
    const Float8 px = simd::Load(&surface.x[i]).value;
    const Float8 py = simd::Load(&surface.y[i]).value;
    const Float8 pz = simd::Load(&surface.z[i]).value;
    const Float8 z = r[6] * px + r[7] * py + r[8] * pz + t[2];
    const Float8 inverse_z = 1.F / z;
    const Float8 u = fx * (r[0] * px + r[1] * py + r[2] * pz + t[0]) * inverse_z + (cx + 0.5F);
    const Float8 v = fy * (r[3] * px + r[4] * py + r[5] * pz + t[1]) * inverse_z + (cy + 0.5F);
    const Int8 visible =
        (pz > 0.F) & (z > kNearest) & (u >= 0.F) & (v >= 0.F) & (u < columns) & (v < rows);
    const Int8 column = simd::ToInt8(u).value & visible;
    const Int8 row = simd::ToInt8(v).value & visible;
    simd::store(&associations.pixels[i], (row * size.width + column) | ~visible);
    simd::store(&associations.x[i], (simd::ToFloat8(column).value - cx) / fx);
    simd::store(&associations.y[i], (simd::ToFloat8(row).value - cy) / fy);
  }
}

// What a loop over points sums, as floats.
struct Accumulated {
  std::array<float, kProducts> products;  // of the Jacobian's columns, from the diagonal on
  std::array<float, 6> gradient;
  float cost;
};

EDVO_CLONES void sum_loop(const SurfacePoints& surface, const DepthAssociations& associations,
                          const RigidMotion& motion, float noise, float weight, std::size_t first,
                          std::size_t last, Accumulated& out) {
  const auto& [r, t] = motion;
  Float8 products[kProducts] = {}, gradient[6] = {}, cost = {};
  const Float8 zero = {};
  for (std::size_t i = first; i < last; i += simd::kWidth) {
    const Float8 z = simd::Load(&associations.z[i]).value;
    const Float8 pz = simd::Load(&surface.z[i]).value;
    const Int8 real = pz > 0.F, measured = real & (z == z);
    // The seen point, moved to the reference camera.
    const Float8 sx = (measured ? simd::Load(&associations.x[i]).value : zero) - t[0];
    const Float8 sy = (measured ? simd::Load(&associations.y[i]).value : zero) - t[1];
    const Float8 sz = (measured ? z : zero + 1.F) - t[2];
    const Float8 x = r[0] * sx + r[3] * sy + r[6] * sz;
    const Float8 y = r[1] * sx + r[4] * sy + r[7] * sz;
    const Float8 d = r[2] * sx + r[5] * sy + r[8] * sz;
    const Float8 nx = simd::Load(&surface.nx[i]).value;
    const Float8 ny = simd::Load(&surface.ny[i]).value;
    const Float8 nz = simd::Load(&surface.nz[i]).value;
    const Float8 residual = nx * x + ny * y + nz * d - 1.F;
    const Float8 sigma = noise * (real ? pz : zero + 1.F);
    const Float8 inverse_variance = 1.F / (sigma * sigma);
    const Float8 square = residual * residual * inverse_variance;
    const Float8 left = 1.F - square * (1.F / (kTukey * kTukey));
    const Float8 inlier = left > 0.F ? left : zero;  // Tukey's biweight
    const Float8 loss = kSaturation * (1.F - inlier * inlier * inlier);
    cost += real ? weight * (measured ? loss : zero + kSaturation) : zero;
    const Float8 w = measured ? weight * inlier * inlier * inverse_variance : zero;
    const Float8 j[6] = {-nx, -ny, -nz, ny * d - nz * y, nz * x - nx * d, nx * y - ny * x};
    const Float8 error = measured ? residual : zero;
    int product = 0;
#pragma GCC unroll 6
    for (int a = 0; a < 6; ++a) {
      const Float8 wj = w * j[a];
#pragma GCC unroll 6
      for (int b = a; b < 6; ++b) products[product++] += wj * j[b];
      gradient[a] += wj * error;
    }
  }
  for (std::size_t p = 0; p < kProducts; ++p) out.products[p] = simd::sum(products[p]);
  for (std::size_t a = 0; a < 6; ++a) out.gradient[a] = simd::sum(gradient[a]);
  out.cost = simd::sum(cost);
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
  project_loop(surface, make_warp(cur_from_ref, camera, Vector6d::Zero()), depth.size(),
               associations);
  depth.look_up(associations.pixels, associations.z);
  for (std::size_t i = 0; i < count; ++i) {
    associations.x[i] *= associations.z[i];
    associations.y[i] *= associations.z[i];
  }
}

PoseSums sum_surface(const SurfacePoints& surface, const DepthAssociations& associations,
                     PointRange range, const SE3& cur_from_ref, float noise, float weight) {
  const RigidMotion motion = rigid_motion(cur_from_ref);
  PoseSums sums;
  Accumulated block;
  for (std::size_t first = range.first; first < range.last; first += kBlock) {
    sum_loop(surface, associations, motion, noise, weight, first,
             std::min(first + kBlock, range.last), block);
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
