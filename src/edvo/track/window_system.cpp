// SPDX-License-Identifier: MIT
#include "edvo/track/window_system.hpp"

#include "edvo/core/simd.hpp"

#include <algorithm>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr double kGainSigma = 0.3;   // prior of the brightness
constexpr double kBiasSigma = 30.0;  // [grey levels]

// Subtracts the part of each point's unknown: H -= c c' / curvature, g -= c gradient / curvature.
EDVO_CLONES void eliminate_depths(const std::vector<DepthSystem>& depths, std::size_t first,
                                  std::size_t count, const std::vector<float>& coupling, int n,
                                  float* hessian, float* gradient) {
  for (std::size_t i = first; i < first + count; ++i) {
    const float* c = &coupling[i * static_cast<std::size_t>(n)];
    const float inverse = 1.F / depths[i].curvature;
    const float relative = depths[i].gradient * inverse;
    for (int a = 0; a < n; ++a) {
      if (c[a] == 0) continue;
      const float scaled = c[a] * inverse;
      float* row = hessian + a * n;
      for (int b = a / kN * kN; b < n; ++b) row[b] -= scaled * c[b];
      gradient[a] -= relative * c[a];
    }
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

// Pair unknowns from the unknowns of host and target.
Eigen::Matrix<double, kN, kN> from_host(const PairGeometry& g) {
  Eigen::Matrix<double, kN, kN> A = Eigen::Matrix<double, kN, kN>::Zero();
  A.topLeftCorner<6, 6>() = g.adjoint;
  A(6, 6) = A(7, 7) = -static_cast<double>(g.gain);
  return A;
}

Eigen::Matrix<double, kN, kN> from_target() {
  Eigen::Matrix<double, kN, kN> A = Eigen::Matrix<double, kN, kN>::Identity();
  A.topLeftCorner<6, 6>() *= -1;
  return A;
}

}  // namespace

WindowSystem linearize_window(const std::vector<WindowKeyframe>& window, const Camera& camera,
                              int fixed, const WindowOptions& options) {
  using BlockMatrix = Eigen::Matrix<double, kN, kN>;
  using BlockVector = Eigen::Matrix<double, kN, 1>;
  const int count = static_cast<int>(window.size());
  const int n = kN * (count - fixed);
  const PairConstants constants = pair_constants(camera, options);
  WindowSystem system{.hessian = Eigen::MatrixXd::Zero(n, n), .gradient = Eigen::VectorXd::Zero(n)};
  std::size_t all_points = 0, most_points = 0;
  for (const WindowKeyframe& key : window) {
    all_points += key.points.size();
    most_points = std::max(most_points, key.points.size());
  }
  system.depths.resize(all_points);
  system.coupling.assign(all_points * static_cast<std::size_t>(n), 0.F);
  std::vector<float> pair_coupling(most_points * kN);
  std::vector<float> eliminated(static_cast<std::size_t>(n * n)),
      eliminated_gradient(static_cast<std::size_t>(n));
  std::size_t first = 0;
  for (int h = 0; h < count; ++h) {
    const WindowKeyframe& host = window[static_cast<std::size_t>(h)];
    for (std::size_t i = 0; i < host.points.size(); ++i) {
      const WindowPoint& point = host.points[i];
      const double error = point.inverse_depth - point.measured;
      system.depths[first + i] = {.gradient = static_cast<float>(point.weight * error),
                                  .curvature = static_cast<float>(point.weight)};
      system.cost += 0.5 * point.weight * error * error;
    }
    const int at_host = kN * (h - fixed);
    for (int t = 0; t < count; ++t) {
      if (t == h || (t < fixed && h < fixed)) continue;
      const WindowKeyframe& target = window[static_cast<std::size_t>(t)];
      const PairGeometry geometry = pair_geometry(host, target);
      PairSums sums;
      system.cost += add_pair(constants, geometry, host.points, target, sums, &system.depths[first],
                              pair_coupling.data());
      const int at_target = kN * (t - fixed);
      const BlockMatrix A = from_host(geometry), B = from_target();
      const BlockMatrix H =
          Eigen::Map<const Eigen::Matrix<float, kN, kN, Eigen::RowMajor>>(sums.hessian.data())
              .cast<double>();
      const BlockVector b =
          Eigen::Map<const Eigen::Matrix<float, kN, 1>>(sums.gradient.data()).cast<double>();
      if (h >= fixed) {
        system.hessian.block<kN, kN>(at_host, at_host) += A.transpose() * H * A;
        system.gradient.segment<kN>(at_host) += A.transpose() * b;
      }
      if (t >= fixed) {
        system.hessian.block<kN, kN>(at_target, at_target) += B.transpose() * H * B;
        system.gradient.segment<kN>(at_target) += B.transpose() * b;
      }
      if (h >= fixed && t >= fixed) {
        const BlockMatrix cross = A.transpose() * H * B;
        system.hessian.block<kN, kN>(at_host, at_target) += cross;
        system.hessian.block<kN, kN>(at_target, at_host) += cross.transpose();
      }
      const Eigen::Matrix<float, kN, kN> At = A.transpose().cast<float>(),
                                         Bt = B.transpose().cast<float>();
      for (std::size_t i = 0; i < host.points.size(); ++i) {
        const Eigen::Map<const Eigen::Matrix<float, kN, 1>> c(&pair_coupling[i * kN]);
        float* row = &system.coupling[(first + i) * static_cast<std::size_t>(n)];
        if (h >= fixed) Eigen::Map<Eigen::Matrix<float, kN, 1>>(row + at_host).noalias() += At * c;
        if (t >= fixed)
          Eigen::Map<Eigen::Matrix<float, kN, 1>>(row + at_target).noalias() += Bt * c;
      }
    }
    std::fill(eliminated.begin(), eliminated.end(), 0.F);
    std::fill(eliminated_gradient.begin(), eliminated_gradient.end(), 0.F);
    eliminate_depths(system.depths, first, host.points.size(), system.coupling, n,
                     eliminated.data(), eliminated_gradient.data());
    for (int a = 0; a < n; ++a) {
      for (int b = a / kN * kN; b < n; ++b) {
        const double value = static_cast<double>(eliminated[static_cast<std::size_t>(a * n + b)]);
        system.hessian(a, b) += value;
        if (b / kN != a / kN) system.hessian(b, a) += value;
      }
      system.gradient[a] += static_cast<double>(eliminated_gradient[static_cast<std::size_t>(a)]);
    }
    first += host.points.size();
  }
  for (int k = fixed; k < count; ++k)
    add_brightness_prior(window[static_cast<std::size_t>(k)], kN * (k - fixed), system);
  return system;
}

void apply_step(const WindowSystem& system, const Eigen::VectorXd& step, int fixed,
                std::vector<WindowKeyframe>& window) {
  const Eigen::VectorXf narrow = step.cast<float>();
  std::size_t i = 0;
  for (int k = 0; k < static_cast<int>(window.size()); ++k) {
    WindowKeyframe& key = window[static_cast<std::size_t>(k)];
    if (k >= fixed) {
      const Eigen::Matrix<double, kN, 1> d = step.segment<kN>(kN * (k - fixed));
      const Vector6d xi = d.head<6>();
      key.world_from_key = key.world_from_key * exp(xi);
      key.gain += d[6];
      key.bias += kBrightnessUnit * d[7];
    }
    for (WindowPoint& point : key.points) {
      const Eigen::Map<const Eigen::VectorXf> coupling(
          &system.coupling[i * static_cast<std::size_t>(step.size())], step.size());
      const float change =
          -(system.depths[i].gradient + coupling.dot(narrow)) / system.depths[i].curvature;
      // The sensor is never wrong by a factor of two; a step that says so comes from a wrong match.
      point.inverse_depth = std::clamp(point.inverse_depth + static_cast<double>(change),
                                       0.5 * point.measured, 2 * point.measured);
      ++i;
    }
  }
}

}  // namespace edvo
