// SPDX-License-Identifier: MIT
#include "edvo/window/window_system.hpp"

#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"
#include "edvo/window/keyframe_unknowns.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace edvo {
namespace {

using simd::Float8;

constexpr int kN = kKeyframeUnknowns;

constexpr std::size_t kAtOnce = 4;  // points: sums over them stay in registers

// Adds a point's coupling to its row of all columns.
[[gnu::always_inline]] inline void add_row(const PosePointBlocks& host, std::size_t point,
                                           float* row) {
  const float* c = host.values.data() + point * host.columns.size() * kN;
  for (const int column : host.columns) {
    simd::store(row + column, simd::Load(row + column).value + simd::Load(c).value);
    c += kN;
  }
}

// Points of a pair that have moved so far have it linearized anew [px]: a fraction of what an image
// is smooth over. Of the newest less, since its pose is what all later ones hang on.
constexpr double kStale = 0.25, kStaleNewest = 0.1;

// Subtracts the part of each point's unknown: H -= c c' / curvature, g -= c gradient / curvature,
// where c is the sum of two systems' couplings. rows: kAtOnce x n, for itself; hessian: the blocks
// from the diagonal on, n x n; n: a multiple of kN.
EDVO_CLONES void schur_complement(const WindowSystem& a, const WindowSystem& b, std::size_t n,
                                  float* rows, float* __restrict hessian,
                                  float* __restrict gradient) {
  std::size_t before = 0;  // points of the hosts before
  for (std::size_t h = 0; h < a.couplings.size(); ++h) {
    const std::size_t points = a.couplings[h].points;
    for (std::size_t first = 0; first < points; first += kAtOnce) {
      float inverse[kAtOnce] = {}, relative[kAtOnce] = {};
      std::fill_n(rows, kAtOnce * n, 0.F);
      for (std::size_t p = 0; p < kAtOnce && first + p < points; ++p) {
        const PointNormals &da = a.depths[before + first + p], &db = b.depths[before + first + p];
        inverse[p] = 1 / (da.curvature + db.curvature);
        relative[p] = (da.gradient + db.gradient) * inverse[p];
        add_row(a.couplings[h], first + p, rows + p * n);
        add_row(b.couplings[h], first + p, rows + p * n);
      }
      const float *c0 = rows, *c1 = rows + n, *c2 = rows + 2 * n, *c3 = rows + 3 * n;
      for (std::size_t block = 0; block < n; block += kN) {
        bool any = false;
        for (std::size_t p = 0; p < kAtOnce; ++p)
          for (std::size_t k = block; k < block + kN; ++k) any |= rows[p * n + k] != 0;
        if (!any) continue;
        for (std::size_t k = block; k < block + kN; ++k)
          for (std::size_t p = 0; p < kAtOnce; ++p) gradient[k] -= relative[p] * rows[p * n + k];
        for (std::size_t k = block; k < block + kN; k += 2) {  // two rows share what they read
          float *row = hessian + k * n, *next = row + n;
          float s[kAtOnce], t[kAtOnce];
          for (std::size_t p = 0; p < kAtOnce; ++p) {
            s[p] = rows[p * n + k] * inverse[p];
            t[p] = rows[p * n + k + 1] * inverse[p];
          }
          for (std::size_t m = block; m < n; m += kN) {
            Float8 x = simd::Load(row + m).value, y = simd::Load(next + m).value;
            x -= s[0] * simd::Load(c0 + m).value;
            y -= t[0] * simd::Load(c0 + m).value;
            x -= s[1] * simd::Load(c1 + m).value;
            y -= t[1] * simd::Load(c1 + m).value;
            x -= s[2] * simd::Load(c2 + m).value;
            y -= t[2] * simd::Load(c2 + m).value;
            x -= s[3] * simd::Load(c3 + m).value;
            y -= t[3] * simd::Load(c3 + m).value;
            simd::store(row + m, x);
            simd::store(next + m, y);
          }
        }
      }
    }
    before += points;
  }
}

// Adds the coupling with the pair's unknowns, (points) x kN, as coupling with the host's and the
// target's, a row of n each point. A' and B': to_host and to_target, column-major.
EDVO_CLONES void spread_coupling(const float* pair, std::size_t points, std::size_t n,
                                 const float* to_host, const float* to_target, float* host,
                                 float* target) {
  for (std::size_t i = 0; i < points; ++i) {
    const float* c = pair + i * kN;
    Float8 sum{};
    if (host != nullptr) {
      for (int k = 0; k < kN; ++k) sum += c[k] * simd::Load(to_host + k * kN).value;
      simd::store(host + i * n, simd::Load(host + i * n).value + sum);
    }
    if (target != nullptr)
      simd::store(target + i * n, simd::Load(target + i * n).value +
                                      simd::Load(to_target).value * simd::Load(c).value);
  }
}

// Where a keyframe's block is in the rows of a host's coupling; nothing where it has none.
float* block_of(PosePointBlocks& host, int column) {
  const auto at = std::find(host.columns.begin(), host.columns.end(), column);
  return at == host.columns.end() ? nullptr : host.values.data() + (at - host.columns.begin()) * kN;
}

// Of each point: its coupling times a step of the keyframes, added to products.
EDVO_CLONES void multiply(const PosePointBlocks& host, const float* step, float* products) {
  const std::size_t width = host.columns.size() * kN;
  for (std::size_t i = 0; i < host.points; ++i) {
    Float8 sum{};
    const float* c = host.values.data() + i * width;
    for (const int column : host.columns) {
      sum += simd::Load(c).value * simd::Load(step + column).value;
      c += kN;
    }
    products[i] += simd::sum(sum);
  }
}

// The couplings of a host's points times their steps, summed into what keyframes feel.
EDVO_CLONES void multiply_transposed(const PosePointBlocks& host, const float* steps, float* pull) {
  const std::size_t width = host.columns.size() * kN;
  for (std::size_t i = 0; i < host.points; ++i) {
    const float* c = host.values.data() + i * width;
    for (const int column : host.columns) {
      simd::store(pull + column, simd::Load(pull + column).value + steps[i] * simd::Load(c).value);
      c += kN;
    }
  }
}

// By a step of the keyframes, of the gradient of each inverse depth.
std::vector<float> depth_pull(const WindowSystem& system, const Eigen::VectorXf& step) {
  std::vector<float> products(system.depths.size());
  float* at = products.data();
  for (const PosePointBlocks& host : system.couplings) {
    multiply(host, step.data(), at);
    at += host.points;
  }
  return products;
}

// Adds a pair whose host and target have their unknowns at these columns, negative: none. coupling,
// depths: the host's.
void add_model(const PairModel& model, int at_host, int at_target, WindowSystem& system,
               PosePointBlocks& coupling, PointNormals* depths) {
  const BlockMatrix A = from_host(model.geometry);
  const BlockVector B =
      Eigen::Map<const Eigen::Matrix<float, kN, 1>>(kFromTarget.data()).cast<double>();
  const BlockMatrix H =
      Eigen::Map<const Eigen::Matrix<float, kN, kN, Eigen::RowMajor>>(model.sums.hessian.data())
          .cast<double>();
  const BlockVector b =
      Eigen::Map<const Eigen::Matrix<float, kN, 1>>(model.sums.gradient.data()).cast<double>();
  if (at_host >= 0) {
    system.hessian.block<kN, kN>(at_host, at_host) += A.transpose() * H * A;
    system.gradient.segment<kN>(at_host) += A.transpose() * b;
  }
  if (at_target >= 0) {
    system.hessian.block<kN, kN>(at_target, at_target) += B.asDiagonal() * H * B.asDiagonal();
    system.gradient.segment<kN>(at_target) += B.asDiagonal() * b;
  }
  if (at_host >= 0 && at_target >= 0) {
    const BlockMatrix cross = A.transpose() * H * B.asDiagonal();
    system.hessian.block<kN, kN>(at_host, at_target) += cross;
    system.hessian.block<kN, kN>(at_target, at_host) += cross.transpose();
  }
  system.cost += model.cost;
  for (std::size_t i = 0; i < coupling.points; ++i) {
    depths[i].gradient += model.point_normals[i].gradient;
    depths[i].curvature += model.point_normals[i].curvature;
  }
  const Eigen::Matrix<float, kN, kN> to_host = A.transpose().cast<float>();
  spread_coupling(model.coupling.data(), coupling.points, coupling.columns.size() * kN,
                  to_host.data(), kFromTarget.data(), block_of(coupling, at_host),
                  block_of(coupling, at_target));
}

void add_priors(const std::vector<WindowKeyframe>& window, int fixed, WindowSystem& system) {
  std::size_t i = 0;
  for (const WindowKeyframe& key : window)
    for (const WindowPoint& point : key.points) {
      const double error = point.inverse_depth - point.measured;
      system.depths[i++] = {.gradient = static_cast<float>(point.weight * error),
                            .curvature = static_cast<float>(point.weight)};
      system.cost += 0.5 * point.weight * error * error;
    }
  for (int k = fixed; k < static_cast<int>(window.size()); ++k) {
    const WindowKeyframe& key = window[static_cast<std::size_t>(k)];
    brightness_prior(key.gain, key.bias).add_to(system, kN * (k - fixed) + 6);
  }
}

}  // namespace

WindowSystem linearize_window(const std::vector<WindowKeyframe>& window, const Camera& camera,
                              int fixed, WindowPairs pairs, const WindowOptions& options,
                              std::vector<PairModel>& models) {
  const int count = static_cast<int>(window.size());
  const int n = kN * (count - fixed);
  const PairConstants constants = pair_constants(camera, options);
  const double limit = pairs == WindowPairs::kNewest ? kStaleNewest : kStale;
  WindowSystem system{.hessian = Eigen::MatrixXd::Zero(n, n), .gradient = Eigen::VectorXd::Zero(n)};
  std::size_t all_points = 0;
  for (const WindowKeyframe& key : window) all_points += key.points.size();
  system.depths.resize(all_points);
  if (pairs == WindowPairs::kOthers) add_priors(window, fixed, system);
  PointNormals* depths = system.depths.data();  // of the host's points
  for (int h = 0; h < count; ++h) {
    const WindowKeyframe& host = window[static_cast<std::size_t>(h)];
    const auto with = [&](int t) {
      const bool newest = h == count - 1 || t == count - 1;
      return t != h && (t >= fixed || h >= fixed) && newest == (pairs == WindowPairs::kNewest);
    };
    PosePointBlocks coupling{.points = host.points.size(), .columns = {}, .values = {}};
    for (int k = fixed; k < count; ++k)
      if (k == h || with(k)) coupling.columns.push_back(kN * (k - fixed));
    coupling.values.resize(host.points.size() * coupling.columns.size() * kN);
    for (int t = 0; t < count; ++t) {
      if (!with(t)) continue;
      PairModel& model = models[static_cast<std::size_t>(h * count + t)];
      update_pair(constants, host, window[static_cast<std::size_t>(t)], limit, model);
      add_model(model, kN * (h - fixed), kN * (t - fixed), system, coupling, depths);
    }
    system.couplings.push_back(std::move(coupling));
    depths += host.points.size();
  }
  return system;
}

WindowStep solve(const WindowSystem& a, const WindowSystem& b, double lambda) {
  using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto n = a.gradient.size();
  RowMatrix by_depths = RowMatrix::Zero(n, n);
  Eigen::VectorXf gradient_by_depths = Eigen::VectorXf::Zero(n);
  std::vector<float> rows(kAtOnce * static_cast<std::size_t>(n));
  schur_complement(a, b, static_cast<std::size_t>(n), rows.data(), by_depths.data(),
                   gradient_by_depths.data());
  Eigen::MatrixXd hessian = a.hessian + b.hessian + by_depths.cast<double>();
  hessian.diagonal() *= 1 + lambda;
  const Eigen::VectorXd gradient = a.gradient + b.gradient + gradient_by_depths.cast<double>();
  WindowStep step{.keyframes = -hessian.selfadjointView<Eigen::Upper>().ldlt().solve(gradient),
                  .depths = std::vector<float>(a.depths.size()),
                  .gradient = gradient};
  const Eigen::VectorXf narrow = step.keyframes.cast<float>();
  const std::vector<float> by_a = depth_pull(a, narrow), by_b = depth_pull(b, narrow);
  for (std::size_t i = 0; i < a.depths.size(); ++i)
    step.depths[i] = -(a.depths[i].gradient + b.depths[i].gradient + by_a[i] + by_b[i]) /
                     (a.depths[i].curvature + b.depths[i].curvature);
  return step;
}

void apply_step(WindowStep& step, int fixed, std::vector<WindowKeyframe>& window) {
  std::size_t i = 0;
  for (int k = 0; k < static_cast<int>(window.size()); ++k) {
    WindowKeyframe& key = window[static_cast<std::size_t>(k)];
    if (k >= fixed) move_keyframe(step.keyframes.segment<kN>(kN * (k - fixed)), key);
    for (WindowPoint& point : key.points) {
      float& depth = step.depths[i++];
      depth = static_cast<float>(move_point(static_cast<double>(depth), point));
    }
  }
}

void move_by(const WindowStep& step, WindowSystem& system) {
  const Eigen::VectorXf narrow = step.keyframes.cast<float>();
  const std::vector<float> by_keyframes = depth_pull(system, narrow);
  double cost = 0;
  for (std::size_t i = 0; i < system.depths.size(); ++i) {
    const float d = step.depths[i];
    PointNormals& depth = system.depths[i];
    cost +=
        static_cast<double>(d * (depth.gradient + by_keyframes[i] + 0.5F * depth.curvature * d));
    depth.gradient += by_keyframes[i] + depth.curvature * d;
  }
  Eigen::VectorXf pull = Eigen::VectorXf::Zero(narrow.size());  // of the depths on the keyframes
  const float* steps = step.depths.data();
  for (const PosePointBlocks& host : system.couplings) {
    multiply_transposed(host, steps, pull.data());
    steps += host.points;
  }
  const Eigen::VectorXd bend = system.hessian * step.keyframes;
  system.cost += cost + step.keyframes.dot(system.gradient + 0.5 * bend);
  system.gradient += bend + pull.cast<double>();
}

}  // namespace edvo
