// SPDX-License-Identifier: MIT
#include "edvo/track/window_system.hpp"

#include "edvo/core/lanes.hpp"
#include "edvo/core/simd.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr double kGainSigma = 0.3;   // prior of the brightness
constexpr double kBiasSigma = 30.0;  // [grey levels]

// Subtracts the part of each point's unknown: H -= c c' / curvature, g -= c gradient / curvature,
// where c is the sum of two systems' couplings. hessian: the blocks from the diagonal on, n x n; n:
// a multiple of kN.
EDVO_CLONES void eliminate(const WindowSystem& a, const WindowSystem& b, int n, float* row_sum,
                           float* __restrict hessian, float* __restrict gradient) {
  for (std::size_t i = 0; i < a.depths.size(); ++i) {
    const float* ca = &a.coupling[i * static_cast<std::size_t>(n)];
    const float* cb = &b.coupling[i * static_cast<std::size_t>(n)];
    const float inverse = 1 / (a.depths[i].curvature + b.depths[i].curvature);
    const float relative = (a.depths[i].gradient + b.depths[i].gradient) * inverse;
    float* c = row_sum;
    for (int k = 0; k < n; k += kN) lanes(c + k) = lanes(ca + k) + lanes(cb + k);
    for (int block = 0; block < n; block += kN) {
      for (int k = block; k < block + kN; ++k) {
        if (c[k] == 0) continue;
        const float scaled = c[k] * inverse;
        float* row = hessian + k * n;
        for (int m = block; m < n; m += kN) lanes(row + m) -= scaled * lanes(c + m);
        gradient[k] -= relative * c[k];
      }
    }
  }
}

// Adds the coupling with the pair's unknowns, (points) x kN, as coupling with the host's and the
// target's, (points) x n each. A' and B': to_host and to_target, column-major.
EDVO_CLONES void spread_coupling(const float* pair, std::size_t points, std::size_t n,
                                 const float* to_host, const float* to_target, float* host,
                                 float* target) {
  for (std::size_t i = 0; i < points; ++i) {
    const float* c = pair + i * kN;
    Floats sum{};
    if (host != nullptr) {
      for (int k = 0; k < kN; ++k) sum += c[k] * lanes(to_host + k * kN);
      lanes(host + i * n) += sum;
    }
    if (target != nullptr) lanes(target + i * n) += lanes(to_target) * lanes(c);
  }
}

void add_brightness_prior(const WindowKeyframe& key, int at, WindowSystem& system) {
  const double gain_weight = 1 / (kGainSigma * kGainSigma);
  const double bias_weight = kBrightnessUnit * kBrightnessUnit / (kBiasSigma * kBiasSigma);
  const double gain_error = key.gain - 1, bias_error = key.bias / kBrightnessUnit;
  system.hessian(at + 6, at + 6) += gain_weight;
  system.hessian(at + 7, at + 7) += bias_weight;
  system.gradient[at + 6] += gain_weight * gain_error;
  system.gradient[at + 7] += bias_weight * bias_error;
  system.cost +=
      0.5 * (gain_weight * gain_error * gain_error + bias_weight * bias_error * bias_error);
}

// Pair unknowns from the unknowns of the host.
Eigen::Matrix<double, kN, kN> from_host(const PairGeometry& g) {
  Eigen::Matrix<double, kN, kN> A = Eigen::Matrix<double, kN, kN>::Zero();
  A.topLeftCorner<6, 6>() = g.adjoint;
  A(6, 6) = A(7, 7) = -static_cast<double>(g.gain);
  return A;
}

// And of the target: the diagonal.
constexpr std::array<float, kN> kFromTarget = {-1, -1, -1, -1, -1, -1, 1, 1};

// Of one point.
Eigen::Map<const Eigen::VectorXf> coupling(const WindowSystem& system, std::size_t point) {
  const auto n = system.gradient.size();
  return {&system.coupling[point * static_cast<std::size_t>(n)], n};
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
  for (int k = fixed; k < static_cast<int>(window.size()); ++k)
    add_brightness_prior(window[static_cast<std::size_t>(k)], kN * (k - fixed), system);
}

}  // namespace

WindowSystem linearize_window(const std::vector<WindowKeyframe>& window, const Camera& camera,
                              int fixed, WindowPairs pairs, const WindowOptions& options) {
  using BlockMatrix = Eigen::Matrix<double, kN, kN>;
  using BlockVector = Eigen::Matrix<double, kN, 1>;
  const int count = static_cast<int>(window.size());
  const int n = kN * (count - fixed);
  const auto width = static_cast<std::size_t>(n);
  const PairConstants constants = pair_constants(camera, options);
  WindowSystem system{.hessian = Eigen::MatrixXd::Zero(n, n), .gradient = Eigen::VectorXd::Zero(n)};
  std::size_t all_points = 0, most_points = 0;
  for (const WindowKeyframe& key : window) {
    all_points += key.points.size();
    most_points = std::max(most_points, key.points.size());
  }
  system.depths.resize(all_points);
  system.coupling.assign(all_points * width, 0.F);
  if (pairs == WindowPairs::kOthers) add_priors(window, fixed, system);
  std::vector<float> pair_coupling(most_points * kN);
  const BlockVector B =
      Eigen::Map<const Eigen::Matrix<float, kN, 1>>(kFromTarget.data()).cast<double>();
  std::size_t first = 0;
  for (int h = 0; h < count; ++h) {
    const WindowKeyframe& host = window[static_cast<std::size_t>(h)];
    const int at_host = kN * (h - fixed);
    for (int t = 0; t < count; ++t) {
      const bool newest = h == count - 1 || t == count - 1;
      if (t == h || (t < fixed && h < fixed) || newest != (pairs == WindowPairs::kNewest)) continue;
      const WindowKeyframe& target = window[static_cast<std::size_t>(t)];
      const PairGeometry geometry = pair_geometry(host, target);
      PairSums sums;
      system.cost += add_pair(constants, geometry, host.points, target, sums, &system.depths[first],
                              pair_coupling.data());
      const int at_target = kN * (t - fixed);
      const BlockMatrix A = from_host(geometry);
      const BlockMatrix H =
          Eigen::Map<const Eigen::Matrix<float, kN, kN, Eigen::RowMajor>>(sums.hessian.data())
              .cast<double>();
      const BlockVector b =
          Eigen::Map<const Eigen::Matrix<float, kN, 1>>(sums.gradient.data()).cast<double>();
      float* host_coupling = nullptr;
      float* target_coupling = nullptr;
      if (h >= fixed) {
        system.hessian.block<kN, kN>(at_host, at_host) += A.transpose() * H * A;
        system.gradient.segment<kN>(at_host) += A.transpose() * b;
        host_coupling = &system.coupling[first * width + static_cast<std::size_t>(at_host)];
      }
      if (t >= fixed) {
        system.hessian.block<kN, kN>(at_target, at_target) += B.asDiagonal() * H * B.asDiagonal();
        system.gradient.segment<kN>(at_target) += B.asDiagonal() * b;
        target_coupling = &system.coupling[first * width + static_cast<std::size_t>(at_target)];
      }
      if (h >= fixed && t >= fixed) {
        const BlockMatrix cross = A.transpose() * H * B.asDiagonal();
        system.hessian.block<kN, kN>(at_host, at_target) += cross;
        system.hessian.block<kN, kN>(at_target, at_host) += cross.transpose();
      }
      const Eigen::Matrix<float, kN, kN> to_host = A.transpose().cast<float>();
      spread_coupling(pair_coupling.data(), host.points.size(), width, to_host.data(),
                      kFromTarget.data(), host_coupling, target_coupling);
    }
    first += host.points.size();
  }
  return system;
}

WindowStep solve(const WindowSystem& a, const WindowSystem& b, double lambda) {
  using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto n = a.gradient.size();
  RowMatrix by_depths = RowMatrix::Zero(n, n);
  Eigen::VectorXf row_sum(n), gradient_by_depths = Eigen::VectorXf::Zero(n);
  eliminate(a, b, static_cast<int>(n), row_sum.data(), by_depths.data(), gradient_by_depths.data());
  Eigen::MatrixXd hessian = a.hessian + b.hessian + by_depths.cast<double>();
  hessian.diagonal() *= 1 + lambda;
  const Eigen::VectorXd gradient = a.gradient + b.gradient + gradient_by_depths.cast<double>();
  WindowStep step{.keyframes = -hessian.selfadjointView<Eigen::Upper>().ldlt().solve(gradient),
                  .depths = std::vector<float>(a.depths.size())};
  const Eigen::VectorXf narrow = step.keyframes.cast<float>();
  for (std::size_t i = 0; i < a.depths.size(); ++i)
    step.depths[i] = -(a.depths[i].gradient + b.depths[i].gradient + coupling(a, i).dot(narrow) +
                       coupling(b, i).dot(narrow)) /
                     (a.depths[i].curvature + b.depths[i].curvature);
  return step;
}

void apply_step(WindowStep& step, int fixed, std::vector<WindowKeyframe>& window) {
  std::size_t i = 0;
  for (int k = 0; k < static_cast<int>(window.size()); ++k) {
    WindowKeyframe& key = window[static_cast<std::size_t>(k)];
    if (k >= fixed) {
      const Eigen::Matrix<double, kN, 1> d = step.keyframes.segment<kN>(kN * (k - fixed));
      const Vector6d xi = d.head<6>();
      key.world_from_key = key.world_from_key * exp(xi);
      key.gain += d[6];
      key.bias += kBrightnessUnit * d[7];
    }
    for (WindowPoint& point : key.points) {
      // The sensor is never wrong by a factor of two; a step that says so comes from a wrong match.
      const double moved = std::clamp(point.inverse_depth + static_cast<double>(step.depths[i]),
                                      0.5 * point.measured, 2 * point.measured);
      step.depths[i++] = static_cast<float>(moved - point.inverse_depth);
      point.inverse_depth = moved;
    }
  }
}

void move_by(const WindowStep& step, WindowSystem& system) {
  const Eigen::VectorXf narrow = step.keyframes.cast<float>();
  Eigen::VectorXf pull = Eigen::VectorXf::Zero(narrow.size());  // of the depths on the keyframes
  double cost = 0;
  for (std::size_t i = 0; i < system.depths.size(); ++i) {
    const float d = step.depths[i];
    DepthSystem& depth = system.depths[i];
    const auto c = coupling(system, i);
    const float by_keyframes = c.dot(narrow);
    pull += d * c;
    cost += static_cast<double>(d * (depth.gradient + by_keyframes + 0.5F * depth.curvature * d));
    depth.gradient += by_keyframes + depth.curvature * d;
  }
  const Eigen::VectorXd bend = system.hessian * step.keyframes;
  system.cost += cost + step.keyframes.dot(system.gradient + 0.5 * bend);
  system.gradient += bend + pull.cast<double>();
}

}  // namespace edvo
