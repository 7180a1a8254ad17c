// SPDX-License-Identifier: MIT
#include "edvo/window/pair_linearization.hpp"

#include "edvo/align/bilinear.hpp"
#include "edvo/align/huber8.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

constexpr int kN = kKeyframeUnknowns;
constexpr float kSaturation = 6.F;  // [sigmas] what a patch out of view or not matching pays
constexpr float kOccluded = 1.10F;  // seen depth nearer by this factor: something stands in front
constexpr float kDepthHuber = 2.F;  // [sigmas]
constexpr std::size_t kAhead = 4;   // points that memory is asked for before their turn

static_assert(kPatchSize == simd::kWidth && kKeyframeUnknowns == simd::kWidth);

// Sums over a patch that all of its second derivatives are made of: the geometry is that of the
// patch's centre, as in DSO, the residuals and gradients are each pixel's own.
enum Sum { kXX, kXY, kYY, kXA, kYA, kX, kY, kAA, kA, kOne, kXR, kYR, kAR, kR, kCost, kSums };

// Asks the memory for what a point's patch will read, so that it is there when its turn comes: the
// images of a window are larger than the caches, and a patch is somewhere in them.
[[gnu::always_inline]] inline void prefetch_patch(const PairConstants& c, const PairGeometry& g,
                                                  const WindowPoint& point,
                                                  const WindowKeyframe& target) {
  const auto& [R, t] = g.target_from_host;
  const auto& [fx, fy, cx, cy] = c.camera;
  const float rho = static_cast<float>(point.inverse_depth);
  const float rx = (point.u - cx) / fx, ry = (point.v - cy) / fy;
  const float iz = 1.F / (R[6] * rx + R[7] * ry + R[8] + rho * t[2]);
  const float u = fx * (R[0] * rx + R[1] * ry + R[2] + rho * t[0]) * iz + cx;
  const float v = fy * (R[3] * rx + R[4] * ry + R[5] + rho * t[1]) * iz + cy;
  if (!(u >= kMargin && v >= kMargin && u < c.limit_u && v < c.limit_v)) return;
  const int column = static_cast<int>(u), row = static_cast<int>(v);
  simd::prefetch(target.half_depth[(row + 1) / 2] + (column + 1) / 2);
  for (int y = row - 3; y <= row + 4; ++y) simd::prefetch(target.gray[y] + column);
}

// Eight points in view, side by side.
struct Block {
  std::size_t count;
  std::size_t index[simd::kWidth];      // which points
  Float8 patches[kSums][simd::kWidth];  // of each sum, its terms in each point's patch
  Float8 x, y;                          // of the points in the target, z = 1
  Float8 scale;                         // of a point's depth in the host by that in the target
  Float8 rho;                           // inverse depth in the host [1 / m]
  Float8 seen;                          // inverse depth in the target, NaN = none [1 / m]
};

constexpr int kProducts = kN * (kN + 1) / 2;

// Sums over points, eight at a time: of products of the Jacobian's columns, from the diagonal on.
struct Totals {
  Float8 products[kProducts] = {}, gradient[kN] = {};
};

// Adds the points of a block; returns their cost.
[[gnu::always_inline]] inline double add_block(const PairConstants& c, const PairGeometry& g,
                                               const Block& block, Totals& totals,
                                               PointNormals* depths, float* coupling) {
  const auto& t = g.target_from_host.t;
  const auto& [fx, fy, cx, cy] = c.camera;
  const Float8 zero{};
  Float8 sum[kSums];
  for (int k = 0; k < kSums; ++k) simd::sum_each(block.patches[k], sum[k]);
  const Float8 &px = block.x, &py = block.y, &scale = block.scale;
  const Float8 inverse_z = block.rho * scale;
  // Depth residual 1 / z - seen, where the target's depth is smooth.
  const Int8 sensed = (block.seen == block.seen) & (zero + c.depth_weight > 0.F);
  const Float8 seen = sensed ? block.seen : inverse_z;
  const Float8 error = inverse_z - seen;
  const Float8 bias = c.depth_bias * seen;
  const Float8 variance = c.depth_variance + bias * bias;
  const Float8 deviation = simd::SquareRoot(variance).value;
  const Huber8 huber(error / deviation, kDepthHuber);
  const Float8 cost = sum[kCost] + c.depth_weight * huber.cost;
  const Int8 fits = cost <= c.most;
  for (int k = 0; k < kSums; ++k) sum[k] = fits ? sum[k] : zero;
  const Float8 depth_weight = (sensed & fits) ? c.depth_weight / variance * huber.weight : zero;

  const float s = 1 / c.sigma, s2 = s * s;
  const float unit = -static_cast<float>(kBrightnessUnit);
  // d (u, v) / d xi at the centre.
  const Float8 du[6] = {fx * inverse_z,       zero,    -fx * px * inverse_z, -fx * px * py,
                        fx * (1.F + px * px), -fx * py};
  const Float8 dv[6] = {zero,         fy * inverse_z, -fy * py * inverse_z, -fy * (1.F + py * py),
                        fy * px * py, fy * px};
  // Gradient-weighted columns of the Jacobian.
  Float8 gu[kN], gv[kN];
#pragma GCC unroll 6
  for (int a = 0; a < 6; ++a) {
    gu[a] = s2 * (sum[kXX] * du[a] + sum[kXY] * dv[a]);
    gv[a] = s2 * (sum[kXY] * du[a] + sum[kYY] * dv[a]);
  }
  gu[6] = s2 * sum[kXA];
  gu[7] = s2 * unit * sum[kX];
  gv[6] = s2 * sum[kYA];
  gv[7] = s2 * unit * sum[kY];
  // 1 / z of the point: d / d xi = -1 / z^2 (0, 0, 1, y z, -x z, 0).
  const Float8 jz[3] = {-inverse_z * inverse_z, -inverse_z * py, inverse_z * px};
  const auto by_depth = [](int a) { return a >= 2 && a < 5; };
  int product = 0;
#pragma GCC unroll 6
  for (int a = 0; a < 6; ++a) {
#pragma GCC unroll 8
    for (int b = a; b < kN; ++b) {
      Float8 p = du[a] * gu[b] + dv[a] * gv[b];
      if (by_depth(a) && by_depth(b)) p += depth_weight * jz[a - 2] * jz[b - 2];
      totals.products[product++] += p;
    }
    Float8 p = s * (sum[kXR] * du[a] + sum[kYR] * dv[a]);
    if (by_depth(a)) p += depth_weight * jz[a - 2] * error;
    totals.gradient[a] += p;
  }
  totals.products[product++] += s2 * sum[kAA];
  totals.products[product++] += s2 * unit * sum[kA];
  totals.products[product++] += s2 * unit * unit * sum[kOne];
  totals.gradient[6] += s * sum[kAR];
  totals.gradient[7] += s * unit * sum[kR];

  // d (u, v) / d rho = f (t - (x, y) t_z) / q_z, and d (1 / z) / d rho.
  const Float8 ru = fx * (t[0] - px * t[2]) * scale, rv = fy * (t[1] - py * t[2]) * scale;
  const Float8 jr = (1.F - block.rho * t[2] * scale) * scale;
  Float8 columns[kN], rows[kN];
#pragma GCC unroll 8
  for (int a = 0; a < kN; ++a) {
    columns[a] = ru * gu[a] + rv * gv[a];
    if (by_depth(a)) columns[a] += depth_weight * jr * jz[a - 2];
  }
  simd::transpose(columns, rows);
  const Float8 gradient = s * (sum[kXR] * ru + sum[kYR] * rv) + depth_weight * jr * error;
  const Float8 curvature =
      s2 * (ru * (sum[kXX] * ru + sum[kXY] * rv) + rv * (sum[kXY] * ru + sum[kYY] * rv)) +
      depth_weight * jr * jr;
  for (std::size_t k = 0; k < block.count; ++k) {
    const std::size_t i = block.index[k];
    simd::store(coupling + i * kN, rows[k]);
    depths[i].gradient += gradient[k];
    depths[i].curvature += curvature[k];
  }
  return static_cast<double>(simd::sum(fits ? cost : zero + c.most));
}

}  // namespace

PairGeometry pair_geometry(const WindowKeyframe& host, const WindowKeyframe& target) {
  const SE3 target_from_host = inverse(target.world_from_key) * host.world_from_key;
  PairGeometry g;
  g.target_from_host = rigid_motion(target_from_host);
  g.adjoint = adjoint(target_from_host);
  g.gain = static_cast<float>(target.gain / host.gain);
  g.bias_host = static_cast<float>(host.bias);
  g.bias_target = static_cast<float>(target.bias);
  g.inverse_host_gain = static_cast<float>(1 / host.gain);
  g.host_rows = row_motion(host.shutter.readout(), target.gray.rows);
  g.target_rows = row_motion(target.shutter.readout(), target.gray.rows);
  return g;
}

PairConstants pair_constants(const Camera& camera, const WindowOptions& options) {
  const float huber = static_cast<float>(options.huber);
  const double noise = options.depth_noise;
  return {.camera = pinhole(camera),
          .limit_u = static_cast<float>(camera.width) - 1 - kMargin,
          .limit_v = static_cast<float>(camera.height) - 1 - kMargin,
          .sigma = static_cast<float>(options.sigma),
          .pair_sigma_scale = static_cast<float>(options.pair_sigma_scale),
          .huber = huber,
          .most = huber * (kSaturation - 0.5F * huber) * kPatchSize,
          .depth_weight = static_cast<float>(options.depth_weight),
          .depth_variance = static_cast<float>(2 * noise * noise),
          .depth_bias = static_cast<float>(options.depth_bias)};
}

EDVO_CLONES double add_pair(const PairConstants& c, const PairGeometry& g,
                            const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                            PairSums& pair, PointNormals* depths, float* coupling) {
  const auto& [R, t] = g.target_from_host;
  const auto& [fx, fy, cx, cy] = c.camera;
  double total = 0;
  const float inverse_sigma = 1 / c.sigma;
  const Float8 pattern_x = simd::Load(kPatternX).value, pattern_y = simd::Load(kPatternY).value;
  Totals totals;
  Block block{};
  for (std::size_t i = 0; i < points.size();) {
    block.count = 0;
    while (block.count < simd::kWidth && i < points.size()) {
      const std::size_t now = i++;
      const WindowPoint& point = points[now];
      if (now + kAhead < points.size()) prefetch_patch(c, g, points[now + kAhead], target);
      simd::store(coupling + now * kN, Float8{});
      const float rho = static_cast<float>(point.inverse_depth);
      const float tx = rho * t[0], ty = rho * t[1], tz = rho * t[2];
      Float8 rx = (point.u + pattern_x - cx) / fx;
      Float8 ry = (point.v + pattern_y - cy) / fy;
      Float8 qx, qy, qz;  // rho times the point in the target
      if (g.host_rows.is_none && g.target_rows.is_none) {
        qx = R[0] * rx + R[1] * ry + (R[2] + tx);
        qy = R[3] * rx + R[4] * ry + (R[5] + ty);
        qz = R[6] * rx + R[7] * ry + (R[8] + tz);
      } else {
        const Float8 inverse_depth = Float8{} + rho;
        Float8 rz = Float8{} + 1.F;
        move_to_middle_row<Float8>(g.host_rows, Float8{} + point.v, rx, ry, rz, inverse_depth);
        qx = R[0] * rx + R[1] * ry + (R[2] * rz + tx);
        qy = R[3] * rx + R[4] * ry + (R[5] * rz + ty);
        qz = R[6] * rx + R[7] * ry + (R[8] * rz + tz);
        move_from_middle_row<Float8>(g.target_rows, fy * qy / qz + cy, qx, qy, qz, inverse_depth);
      }
      const Float8 iz = 1.F / qz;
      const Float8 x = qx * iz;
      const Float8 y = qy * iz;
      const Float8 u = fx * x + cx;
      const Float8 v = fy * y + cy;
      const Int8 fits =
          (qz > kLeastScale) & (u >= kMargin) & (v >= kMargin) & (u < c.limit_u) & (v < c.limit_v);
      std::int32_t visible = -1;
      for (int k = 0; k < kPatchSize; ++k) visible &= fits[k];
      if (visible == 0) {
        total += static_cast<double>(c.most);
        continue;
      }
      const float seen = inverse_depth_at(target, u[0], v[0]);
      if (seen > kOccluded * rho * iz[0]) {
        total += static_cast<double>(c.most);
        continue;
      }
      Samples image;
      sample(target.gray, u, v, image);
      const Float8 radiance = simd::Load(point.intensity.data()).value - g.bias_host;
      const Float8 r = (image.value - g.gain * radiance - g.bias_target) * inverse_sigma;
      const Huber8 huber(r, c.huber);
      const Float8 gradient_weight_scale = simd::Load(point.gradient_weight_scale.data()).value;
      const Float8 w = gradient_weight_scale * huber.weight;
      const Float8 by_gain = -radiance * g.inverse_host_gain;
      const Float8 wx = w * image.gx, wy = w * image.gy, wa = w * by_gain;
      const std::size_t k = block.count++;
      block.index[k] = now;
      block.patches[kXX][k] = wx * image.gx;
      block.patches[kXY][k] = wx * image.gy;
      block.patches[kYY][k] = wy * image.gy;
      block.patches[kXA][k] = wx * by_gain;
      block.patches[kYA][k] = wy * by_gain;
      block.patches[kX][k] = wx;
      block.patches[kY][k] = wy;
      block.patches[kAA][k] = wa * by_gain;
      block.patches[kA][k] = wa;
      block.patches[kOne][k] = w;
      block.patches[kXR][k] = wx * r;
      block.patches[kYR][k] = wy * r;
      block.patches[kAR][k] = wa * r;
      block.patches[kR][k] = w * r;
      block.patches[kCost][k] = gradient_weight_scale * huber.cost;
      block.x[k] = x[0];
      block.y[k] = y[0];
      block.scale[k] = iz[0];
      block.rho[k] = rho;
      block.seen[k] = seen;
    }
    for (std::size_t k = block.count; k < simd::kWidth; ++k) {  // left over: weighs nothing
      for (Float8(&patch)[simd::kWidth] : block.patches) patch[k] = Float8{};
      block.seen[k] = std::numeric_limits<float>::quiet_NaN();
    }
    if (block.count > 0) total += add_block(c, g, block, totals, depths, coupling);
  }
  int product = 0;
  for (int a = 0; a < kN; ++a) {
    for (int b = a; b < kN; ++b) {
      const float value = simd::sum(totals.products[product++]);
      pair.hessian[static_cast<std::size_t>(a * kN + b)] += value;
      if (b > a) pair.hessian[static_cast<std::size_t>(b * kN + a)] += value;
    }
    pair.gradient[static_cast<std::size_t>(a)] += simd::sum(totals.gradient[a]);
  }
  return total;
}

}  // namespace edvo
