// SPDX-License-Identifier: MIT
#include "edvo/track/photometric.hpp"

#include "edvo/core/lanes.hpp"
#include "edvo/core/simd.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace edvo {
namespace {

constexpr int kUnknowns = 8;
constexpr int kColumns = kUnknowns - 1;  // of the Jacobian; the bias' is the same for all points
constexpr int kPoseProducts = 21;
constexpr std::size_t kBlock = 256;   // sums of floats stay short, sums of blocks are double
constexpr float kSurfaceTukey = 6.F;  // [sigmas] farther off, it is another surface
constexpr float kSurfaceSaturation = kSurfaceTukey * kSurfaceTukey / 6.F;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// A rigid motion and a projection as plain numbers.
struct View {
  std::array<float, 9> r;  // row-major
  std::array<float, 3> t;
  float fx, fy, cx, cy;
};

View make_view(const SE3& motion, const Camera& camera) {
  View view{};
  const Eigen::Matrix3d R = motion.rotation.toRotationMatrix();
  for (int i = 0; i < 9; ++i)
    view.r[static_cast<std::size_t>(i)] = static_cast<float>(R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i)
    view.t[static_cast<std::size_t>(i)] = static_cast<float>(motion.translation[i]);
  view.fx = static_cast<float>(camera.fx);
  view.fy = static_cast<float>(camera.fy);
  view.cx = static_cast<float>(camera.cx);
  view.cy = static_cast<float>(camera.cy);
  return view;
}

EDVO_CLONES void residual_loop(const ReferenceLevel& reference, const cv::Mat_<std::uint8_t>& gray,
                               const View& view, float gain, float bias, float* residuals) {
  const auto& [r, t, fx, fy, cx, cy] = view;
  const auto stride = static_cast<int>(gray.step[0]);
  const std::uint8_t* pixels = gray[0];
  // One pixel of margin, as the Jacobian's differences have it in the reference.
  const float limit_u = static_cast<float>(gray.cols - 2);
  const float limit_v = static_cast<float>(gray.rows - 2);
  for (std::size_t i = 0; i < reference.count; i += kLanes) {
    const Floats& px = lanes(&reference.x[i]);
    const Floats& py = lanes(&reference.y[i]);
    const Floats& pz = lanes(&reference.z[i]);
    const Floats z = r[6] * px + r[7] * py + r[8] * pz + t[2];
    const Floats inverse_z = 1.F / z;
    const Floats u = fx * (r[0] * px + r[1] * py + r[2] * pz + t[0]) * inverse_z + cx;
    const Floats v = fy * (r[3] * px + r[4] * py + r[5] * pz + t[1]) * inverse_z + cy;
    const Ints visible =
        (pz > 0.F) & (z > kNearest) & (u >= 1.F) & (v >= 1.F) & (u < limit_u) & (v < limit_v);
    const Ints column = __builtin_convertvector(u, Ints) & visible;
    const Ints row = __builtin_convertvector(v, Ints) & visible;
    const Ints offset = row * stride + column;
    Ints top, bottom;  // two neighbours each, the left one in the low byte
    for (std::size_t k = 0; k < kLanes; ++k) {
      std::uint16_t pair;
      const std::uint8_t* p = pixels + offset[k];
      std::memcpy(&pair, p, sizeof pair);
      top[k] = pair;
      std::memcpy(&pair, p + stride, sizeof pair);
      bottom[k] = pair;
    }
    const Ints top_left = top & 255, bottom_left = bottom & 255;
    const Ints top_right = top >> 8, bottom_right = bottom >> 8;
    const Floats a = u - __builtin_convertvector(column, Floats);
    const Floats b = v - __builtin_convertvector(row, Floats);
    const Floats upper = __builtin_convertvector(top_left, Floats) +
                         a * __builtin_convertvector(top_right - top_left, Floats);
    const Floats lower = __builtin_convertvector(bottom_left, Floats) +
                         a * __builtin_convertvector(bottom_right - bottom_left, Floats);
    const Floats residual =
        upper + b * (lower - upper) - gain * lanes(&reference.intensity[i]) - bias;
    const Floats none = residual * 0.F + kNan;
    lanes(residuals + i) = visible ? residual : none;
  }
}

struct LossConstants {
  Loss loss;
  float parameter, inverse_sigma, outside;
};

// What each point of a block weighs, and that times its residual. Returns the cost.
EDVO_CLONES float weigh_block(const float* residuals, const float* point_weights, std::size_t count,
                              const LossConstants& c, float* __restrict weights,
                              float* __restrict weighted) {
  Floats cost = {};
  const Floats zero = {};
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Floats& residual = lanes(residuals + i);
    const Floats& point_weight = lanes(point_weights + i);
    const Ints seen = residual == residual;
    const Floats r = seen ? residual : zero;
    const Floats s = r * c.inverse_sigma;
    Floats loss, weight;
    if (c.loss == Loss::kHuber) {
      const Floats size = s < 0.F ? -s : s;
      const Floats inlier = size < c.parameter ? size : zero + c.parameter;
      loss = inlier * (size - 0.5F * inlier);
      weight = size > c.parameter ? c.parameter / size : zero + 1.F;
    } else if (c.loss == Loss::kTukey) {
      const float square = c.parameter * c.parameter;
      const Floats left = 1.F - s * s / square;
      const Floats inlier = left > 0.F ? left : zero;
      loss = square / 6.F * (1.F - inlier * inlier * inlier);
      weight = inlier * inlier;
    } else {
      for (std::size_t k = 0; k < kLanes; ++k) {
        const RobustValue value = robust(c.loss, c.parameter, s[k]);
        loss[k] = value.cost;
        weight[k] = value.weight;
      }
    }
    cost += (seen ? loss : zero + c.outside) * point_weight;
    const Floats w = seen ? weight * point_weight * (c.inverse_sigma * c.inverse_sigma) : zero;
    lanes(weights + i) = w;
    lanes(weighted + i) = w * r;
  }
  return sum_of(cost);
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
  Floats products[kColumns - a] = {}, sum = {}, gradient = {};
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Floats& column = lanes(columns[a] + i);
    const Floats w = lanes(weights + i) * column;
    sum += w;
    gradient += lanes(weighted + i) * column;
#pragma GCC unroll 8
    for (int b = a; b < kColumns; ++b)
      products[b - a] += w * lanes(columns[static_cast<std::size_t>(b)] + i);
  }
  for (int b = a; b < kColumns; ++b)
    out.products[a][static_cast<std::size_t>(b)] = sum_of(products[b - a]);
  out.sums[a] = sum_of(sum);
  out.gradient[a] = sum_of(gradient);
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
  Floats all = {}, residuals = {};
  for (std::size_t i = 0; i < count; i += kLanes) {
    all += lanes(weights + i);
    residuals += lanes(weighted + i);
  }
  out.weights = sum_of(all);
  out.weighted = sum_of(residuals);
}

// The Jacobian's columns are the reference's times the gain, -intensity, and -kIntensityUnit.
void add(const ColumnSums& block, double gain, PhotometricSums& sums) {
  constexpr double kUnit = static_cast<double>(kIntensityUnit);
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

// What the loop over the surface sums, as floats.
struct Accumulated {
  std::array<float, kPoseProducts> products;  // of the Jacobian's columns, from the diagonal on
  std::array<float, 6> gradient;
  float cost;
};

struct SurfaceConstants {
  View view;
  float noise, weight;
};

EDVO_CLONES void surface_loop(const SurfacePoints& surface, const cv::Mat_<float>& depth,
                              const SurfaceConstants& c, std::size_t first, std::size_t last,
                              Accumulated& out) {
  const auto& [r, t, fx, fy, cx, cy] = c.view;
  Floats products[kPoseProducts] = {}, gradient[6] = {}, cost = {};
  const Floats zero = {};
  const auto stride = static_cast<int>(depth.step1());
  const float* pixels = depth[0];
  const float columns = static_cast<float>(depth.cols), rows = static_cast<float>(depth.rows);
  for (std::size_t i = first; i < last; i += kLanes) {
    const Floats& px = lanes(&surface.x[i]);
    const Floats& py = lanes(&surface.y[i]);
    const Floats& pz = lanes(&surface.z[i]);
    const Floats qz = r[6] * px + r[7] * py + r[8] * pz + t[2];
    const Floats inverse_z = 1.F / qz;
    const Floats u = fx * (r[0] * px + r[1] * py + r[2] * pz + t[0]) * inverse_z + (cx + 0.5F);
    const Floats v = fy * (r[3] * px + r[4] * py + r[5] * pz + t[1]) * inverse_z + (cy + 0.5F);
    const Ints real = pz > 0.F;
    const Ints visible =
        real & (qz > kNearest) & (u >= 0.F) & (v >= 0.F) & (u < columns) & (v < rows);
    const Ints column = __builtin_convertvector(u, Ints) & visible;
    const Ints row = __builtin_convertvector(v, Ints) & visible;
    const Ints offset = row * stride + column;
    Floats z;
    for (std::size_t k = 0; k < kLanes; ++k) z[k] = pixels[offset[k]];
    const Ints measured = visible & (z == z);
    z = measured ? z : zero + 1.F;
    // The seen point, moved to the reference camera.
    const Floats sx = (__builtin_convertvector(column, Floats) - cx) / fx * z - t[0];
    const Floats sy = (__builtin_convertvector(row, Floats) - cy) / fy * z - t[1];
    const Floats sz = z - t[2];
    const Floats x = r[0] * sx + r[3] * sy + r[6] * sz;
    const Floats y = r[1] * sx + r[4] * sy + r[7] * sz;
    const Floats d = r[2] * sx + r[5] * sy + r[8] * sz;
    const Floats& nx = lanes(&surface.nx[i]);
    const Floats& ny = lanes(&surface.ny[i]);
    const Floats& nz = lanes(&surface.nz[i]);
    const Floats residual = nx * x + ny * y + nz * d - 1.F;
    const Floats sigma = c.noise * (real ? pz : zero + 1.F);
    const Floats inverse_variance = 1.F / (sigma * sigma);
    const Floats square = residual * residual * inverse_variance;
    const Floats left = 1.F - square * (1.F / (kSurfaceTukey * kSurfaceTukey));
    const Floats inlier = left > 0.F ? left : zero;  // Tukey's biweight
    const Floats loss = kSurfaceSaturation * (1.F - inlier * inlier * inlier);
    cost += real ? c.weight * (measured ? loss : zero + kSurfaceSaturation) : zero;
    const Floats w = measured ? c.weight * inlier * inlier * inverse_variance : zero;
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
  for (std::size_t p = 0; p < kPoseProducts; ++p) out.products[p] = sum_of(products[p]);
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

void photometric_residuals(const ReferenceLevel& reference, const Level& current,
                           const Alignment& alignment, std::vector<float>& residuals) {
  residuals.resize(reference.x.size());
  residual_loop(reference, current.gray, make_view(alignment.cur_from_ref, current.camera),
                static_cast<float>(alignment.gain), static_cast<float>(alignment.bias),
                residuals.data());
}

PhotometricSums sum_photometric(const ReferenceLevel& reference,
                                const std::vector<float>& residuals, double gain, float sigma,
                                Loss loss, float loss_parameter) {
  const LossConstants constants{.loss = loss,
                                .parameter = loss_parameter,
                                .inverse_sigma = 1.F / sigma,
                                .outside = robust(loss, loss_parameter, kInlierSigmas).cost};
  PhotometricSums sums;
  std::array<float, kBlock> weights, weighted;
  ColumnSums block;
  for (std::size_t first = 0; first < residuals.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, residuals.size() - first);
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

PoseSums sum_surface(const SurfacePoints& surface, const Camera& camera,
                     const cv::Mat_<float>& depth, const SE3& cur_from_ref, float noise,
                     float weight) {
  const SurfaceConstants constants{make_view(cur_from_ref, camera), noise, weight};
  PoseSums sums;
  Accumulated block;
  for (std::size_t first = 0; first < surface.x.size(); first += kBlock) {
    surface_loop(surface, depth, constants, first, std::min(first + kBlock, surface.x.size()),
                 block);
    add(block, sums);
  }
  return sums;
}

float surface_sigma(const SurfacePoints& surface, const Camera& camera,
                    const cv::Mat_<float>& depth, const SE3& cur_from_ref,
                    std::vector<float>& errors) {
  constexpr std::size_t kEvery = 4;  // points: a median needs no more
  const Eigen::Matrix3f R = cur_from_ref.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = cur_from_ref.translation.cast<float>();
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  errors.clear();
  errors.reserve(surface.x.size() / kEvery + 1);
  for (std::size_t i = 0; i < surface.x.size(); i += kEvery) {
    const Eigen::Vector3f q = R * Eigen::Vector3f(surface.x[i], surface.y[i], surface.z[i]) + t;
    const float u = fx * q.x() / q.z() + cx + 0.5F, v = fy * q.y() / q.z() + cy + 0.5F;
    const bool visible = surface.z[i] > 0 && q.z() > kNearest && u >= 0 && v >= 0 &&
                         u < static_cast<float>(depth.cols) && v < static_cast<float>(depth.rows);
    if (!visible) continue;
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const float z = depth(row, column);
    const Eigen::Vector3f seen((static_cast<float>(column) - cx) / fx * z,
                               (static_cast<float>(row) - cy) / fy * z, z);
    const Eigen::Vector3f normal(surface.nx[i], surface.ny[i], surface.nz[i]);
    errors.push_back((normal.dot(R.transpose() * (seen - t)) - 1.F) / surface.z[i]);
  }
  return mad_sigma(errors);
}

}  // namespace edvo
