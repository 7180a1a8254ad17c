// SPDX-License-Identifier: MIT
#include "edvo/align/photometric.hpp"

#include "edvo/align/huber8.hpp"
#include "edvo/align/warp.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

constexpr int kUnknowns = 8;
constexpr int kColumns = kUnknowns - 1;  // of the Jacobian; the bias' is the same for all points
constexpr std::size_t kBlock = 256;      // sums of floats stay short, sums of blocks are double
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

EDVO_CLONES void residual_loop(const ReferenceLevel& reference, const cv::Mat_<std::uint8_t>& gray,
                               const Warp& warp, float gain, float bias, float* residuals) {
  const auto& [r, t] = warp.motion;
  const auto& [fx, fy, cx, cy] = warp.camera;
  const auto stride = static_cast<int>(gray.step[0]);
  const std::uint8_t* pixels = gray[0];
  // One pixel of margin, as the Jacobian's differences have it in the reference.
  const float limit_u = static_cast<float>(gray.cols - 2);
  const float limit_v = static_cast<float>(gray.rows - 2);
  for (std::size_t i = 0; i < reference.count; i += simd::kWidth) {
    const Float8 px = simd::Load(&reference.x[i]).value;
    const Float8 py = simd::Load(&reference.y[i]).value;
    const Float8 pz = simd::Load(&reference.z[i]).value;
    Float8 x = r[0] * px + r[1] * py + r[2] * pz + t[0];
    Float8 y = r[3] * px + r[4] * py + r[5] * pz + t[1];
    Float8 z = r[6] * px + r[7] * py + r[8] * pz + t[2];
    if (!warp.rows.is_none)
      move_from_middle_row<Float8>(warp.rows, fy * y / z + cy, x, y, z, Float8{} + 1.F);
    const Float8 inverse_z = 1.F / z;
    const Float8 u = fx * x * inverse_z + cx;
    const Float8 v = fy * y * inverse_z + cy;
    const Int8 visible =
        (pz > 0.F) & (z > kNearest) & (u >= 1.F) & (v >= 1.F) & (u < limit_u) & (v < limit_v);
    const Int8 column = simd::ToInt8(u).value & visible;
    const Int8 row = simd::ToInt8(v).value & visible;
    const Int8 offset = row * stride + column;
    Int8 top, bottom;  // two neighbours each, the left one in the low byte
    for (std::size_t k = 0; k < simd::kWidth; ++k) {
      std::uint16_t pair = 0;
      const std::uint8_t* p = pixels + offset[k];
      std::memcpy(&pair, p, sizeof pair);
      top[k] = pair;
      std::memcpy(&pair, p + stride, sizeof pair);
      bottom[k] = pair;
    }
    const Int8 top_left = top & 255, bottom_left = bottom & 255;
    const Int8 top_right = top >> 8, bottom_right = bottom >> 8;
    const Float8 a = u - simd::ToFloat8(column).value;
    const Float8 b = v - simd::ToFloat8(row).value;
    const Float8 upper =
        simd::ToFloat8(top_left).value + a * simd::ToFloat8(top_right - top_left).value;
    const Float8 lower =
        simd::ToFloat8(bottom_left).value + a * simd::ToFloat8(bottom_right - bottom_left).value;
    const Float8 residual =
        upper + b * (lower - upper) - gain * simd::Load(&reference.intensity[i]).value - bias;
    const Float8 none = residual * 0.F + kNan;
    simd::store(residuals + i, visible ? residual : none);
  }
}

struct LossConstants {
  Loss loss;
  float parameter, inverse_sigma, outside;
};

LossConstants loss_constants(float sigma, Loss loss, float parameter) {
  return {.loss = loss,
          .parameter = parameter,
          .inverse_sigma = 1.F / sigma,
          .outside = robust(loss, parameter, kInlierSigmas).cost};
}

// What each point of a block weighs, and that times its residual. Returns the cost.
EDVO_CLONES float weigh_block(const float* residuals, const float* point_weights, std::size_t count,
                              const LossConstants& c, float* __restrict weights,
                              float* __restrict weighted) {
  Float8 cost = {};
  const Float8 zero = {};
  for (std::size_t i = 0; i < count; i += simd::kWidth) {
    const Float8 residual = simd::Load(residuals + i).value;
    const Float8 point_weight = simd::Load(point_weights + i).value;
    const Int8 seen = residual == residual;
    const Float8 r = seen ? residual : zero;
    const Float8 s = r * c.inverse_sigma;
    Float8 loss, weight;
    if (c.loss == Loss::kHuber) {
      const Huber8 huber(s, c.parameter);
      loss = huber.cost;
      weight = huber.weight;
    } else if (c.loss == Loss::kTukey) {
      const float square = c.parameter * c.parameter;
      const Float8 left = 1.F - s * s / square;
      const Float8 inlier = left > 0.F ? left : zero;
      loss = square / 6.F * (1.F - inlier * inlier * inlier);
      weight = inlier * inlier;
    } else {  // Student
      const Float8 spread = 1.F + s * s / c.parameter;
      loss = 0.5F * (c.parameter + 1.F) * simd::Log(spread).value;
      weight = (c.parameter + 1.F) / (c.parameter * spread);
    }
    cost += (seen ? loss : zero + c.outside) * point_weight;
    const Float8 w = seen ? weight * point_weight * (c.inverse_sigma * c.inverse_sigma) : zero;
    simd::store(weights + i, w);
    simd::store(weighted + i, w * r);
  }
  return simd::sum(cost);
}

// Sums over a block: of weighted products of columns (from the diagonal on), of weighted columns,
// of columns times weighted residuals, and of weights and weighted residuals themselves.
struct ColumnSums {
  std::array<std::array<float, kColumns>, kColumns> products;
  std::array<float, kColumns> sums, gradient;
  float weights, weighted;
};

using Columns = std::array<const float*, kColumns>;

// What has column a as the first of a product: few enough sums to stay in registers.
template <int a>
[[gnu::always_inline]] inline void sum_column(const Columns& columns, const float* weights,
                                              const float* weighted, std::size_t count,
                                              ColumnSums& out) {
  Float8 products[kColumns - a] = {}, sum = {}, gradient = {};
  for (std::size_t i = 0; i < count; i += simd::kWidth) {
    const Float8 column = simd::Load(columns[a] + i).value;
    const Float8 w = simd::Load(weights + i).value * column;
    sum += w;
    gradient += simd::Load(weighted + i).value * column;
#pragma GCC unroll 8
    for (int b = a; b < kColumns; ++b)
      products[b - a] += w * simd::Load(columns[static_cast<std::size_t>(b)] + i).value;
  }
  for (int b = a; b < kColumns; ++b)
    out.products[a][static_cast<std::size_t>(b)] = simd::sum(products[b - a]);
  out.sums[a] = simd::sum(sum);
  out.gradient[a] = simd::sum(gradient);
}

EDVO_CLONES void sum_columns(const Columns& columns, const float* weights, const float* weighted,
                             std::size_t count, ColumnSums& out) {
  sum_column<0>(columns, weights, weighted, count, out);
  sum_column<1>(columns, weights, weighted, count, out);
  sum_column<2>(columns, weights, weighted, count, out);
  sum_column<3>(columns, weights, weighted, count, out);
  sum_column<4>(columns, weights, weighted, count, out);
  sum_column<5>(columns, weights, weighted, count, out);
  sum_column<6>(columns, weights, weighted, count, out);
  Float8 all = {}, residuals = {};
  for (std::size_t i = 0; i < count; i += simd::kWidth) {
    all += simd::Load(weights + i).value;
    residuals += simd::Load(weighted + i).value;
  }
  out.weights = simd::sum(all);
  out.weighted = simd::sum(residuals);
}

// The Jacobian's columns are the reference's times the gain, -intensity, and -kBrightnessUnit.
void add(const ColumnSums& block, double gain, PhotometricSums& sums) {
  constexpr double kUnit = kBrightnessUnit;
  const auto times = [&](int column) { return column < kColumns - 1 ? gain : -1.0; };
  for (int a = 0; a < kColumns; ++a) {
    const auto row = static_cast<std::size_t>(a);
    for (int b = a; b < kColumns; ++b)
      sums.hessian(a, b) += times(a) * times(b) *
                            static_cast<double>(block.products[row][static_cast<std::size_t>(b)]);
    sums.hessian(a, kColumns) -= kUnit * times(a) * static_cast<double>(block.sums[row]);
    sums.gradient[a] += times(a) * static_cast<double>(block.gradient[row]);
  }
  sums.hessian(kColumns, kColumns) += kUnit * kUnit * static_cast<double>(block.weights);
  sums.gradient[kColumns] -= kUnit * static_cast<double>(block.weighted);
}

}  // namespace

void photometric_residuals(const ReferenceLevel& reference, const Level& current,
                           const Vector6d& readout, const Alignment& alignment,
                           std::vector<float>& residuals) {
  residuals.resize(reference.x.size());
  residual_loop(reference, current.gray, make_warp(alignment.cur_from_ref, current.camera, readout),
                static_cast<float>(alignment.gain), static_cast<float>(alignment.bias),
                residuals.data());
}

double photometric_cost(const ReferenceLevel& reference, const std::vector<float>& residuals,
                        float sigma, Loss loss, float loss_parameter) {
  const LossConstants constants = loss_constants(sigma, loss, loss_parameter);
  std::array<float, kBlock> weights, weighted;
  double cost = 0;
  for (std::size_t first = 0; first < residuals.size(); first += kBlock)
    cost += static_cast<double>(weigh_block(
        residuals.data() + first, reference.weight.data() + first,
        std::min(kBlock, residuals.size() - first), constants, weights.data(), weighted.data()));
  return cost;
}

PhotometricSums sum_photometric(const ReferenceLevel& reference,
                                const std::vector<float>& residuals, PointRange range, double gain,
                                float sigma, Loss loss, float loss_parameter) {
  const LossConstants constants = loss_constants(sigma, loss, loss_parameter);
  PhotometricSums sums;
  std::array<float, kBlock> weights, weighted;
  ColumnSums block;
  for (std::size_t first = range.first; first < range.last; first += kBlock) {
    const std::size_t count = std::min(kBlock, range.last - first);
    sums.cost +=
        static_cast<double>(weigh_block(residuals.data() + first, reference.weight.data() + first,
                                        count, constants, weights.data(), weighted.data()));
    Columns columns;
    for (std::size_t k = 0; k < 6; ++k) columns[k] = reference.jacobian[k].data() + first;
    columns[6] = reference.intensity.data() + first;
    sum_columns(columns, weights.data(), weighted.data(), count, block);
    add(block, gain, sums);
  }
  return sums;
}

}  // namespace edvo
