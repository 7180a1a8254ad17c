// SPDX-License-Identifier: MIT
#include "edvo/track/window_system.hpp"

#include "edvo/core/simd.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr float kMargin = 3.F;       // [px] room that a patch needs
constexpr float kSaturation = 6.F;   // [sigmas] what a patch out of view or not matching pays
constexpr float kOccluded = 1.10F;   // seen depth nearer by this factor: something stands in front
constexpr float kDepthHuber = 2.F;   // [sigmas]
constexpr double kGainSigma = 0.3;   // prior of the brightness
constexpr double kBiasSigma = 30.0;  // [grey levels]

// Sums over a patch that all of its second derivatives are made of: the geometry is that of the
// patch's centre, as in DSO, the residuals and gradients are each pixel's own.
enum Sum { kXX, kXY, kYY, kXA, kYA, kX, kY, kAA, kA, kOne, kXR, kYR, kAR, kR, kCost, kSums };

struct PairGeometry {
  std::array<float, 9> rotation;  // row-major, target from host
  std::array<float, 3> translation;
  Matrix6d adjoint;
  float gain, bias_host, bias_target;
  float inverse_host_gain;
};

// What does not change during a linearization.
struct Constants {
  float fx, fy, cx, cy, limit_u, limit_v;
  float inverse_sigma, huber, most;
  float geometric, depth_variance, depth_bias;
};

// What a pair of keyframes adds; unknowns are the relative twist (moving host points), the gain and
// the bias of the target. The host's own act through the same columns.
struct PairSums {
  std::array<float, kN * kN> hessian{};
  std::array<float, kN> gradient{};
};

using Vec4 = float __attribute__((vector_size(16), aligned(4)));

inline Vec4 load(const cv::Vec4f& v) {
  Vec4 out;
  __builtin_memcpy(&out, &v, sizeof out);
  return out;
}

PairGeometry pair_geometry(const WindowKeyframe& host, const WindowKeyframe& target) {
  const SE3 target_from_host = inverse(target.world_from_key) * host.world_from_key;
  const Eigen::Matrix3d R = target_from_host.rotation.toRotationMatrix();
  PairGeometry g;
  for (int i = 0; i < 9; ++i)
    g.rotation[static_cast<std::size_t>(i)] = static_cast<float>(R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i)
    g.translation[static_cast<std::size_t>(i)] =
        static_cast<float>(target_from_host.translation[i]);
  g.adjoint = adjoint(target_from_host);
  g.gain = static_cast<float>(target.gain / host.gain);
  g.bias_host = static_cast<float>(host.bias);
  g.bias_target = static_cast<float>(target.bias);
  g.inverse_host_gain = static_cast<float>(1 / host.gain);
  return g;
}

// Adds all points of a host as seen in a target. coupling: (points) x kN of this pair, zero where a
// point is not seen. Returns the cost.
EDVO_CLONES double add_pair(const Constants& c, const PairGeometry& g,
                            const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                            PairSums& pair, DepthSystem* depths, float* coupling) {
  const auto& R = g.rotation;
  const auto& t = g.translation;
  double total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const WindowPoint& point = points[i];
    float* couple = coupling + i * kN;
    const float rho = static_cast<float>(point.inverse_depth);
    const float tx = rho * t[0], ty = rho * t[1], tz = rho * t[2];
    float x[kPatchSize], y[kPatchSize], u[kPatchSize], v[kPatchSize], iz[kPatchSize];
    int visible = 1;
    for (int k = 0; k < kPatchSize; ++k) {
      const float rx = (point.u + kPatternX[k] - c.cx) / c.fx;
      const float ry = (point.v + kPatternY[k] - c.cy) / c.fy;
      const float qz = R[6] * rx + R[7] * ry + R[8] + tz;  // rho times the point in the target
      iz[k] = 1.F / qz;
      x[k] = (R[0] * rx + R[1] * ry + R[2] + tx) * iz[k];
      y[k] = (R[3] * rx + R[4] * ry + R[5] + ty) * iz[k];
      u[k] = c.fx * x[k] + c.cx;
      v[k] = c.fy * y[k] + c.cy;
      visible &= static_cast<int>(qz > 0.05F) & static_cast<int>(u[k] >= kMargin) &
                 static_cast<int>(v[k] >= kMargin) & static_cast<int>(u[k] < c.limit_u) &
                 static_cast<int>(v[k] < c.limit_v);
    }
    for (int j = 0; j < kN; ++j) couple[j] = 0;
    if (visible == 0) {
      total += static_cast<double>(c.most);
      continue;
    }
    const float seen = target.inverse_depth(static_cast<int>(0.5F * v[0] + 0.5F),
                                            static_cast<int>(0.5F * u[0] + 0.5F));
    const float inverse_z = rho * iz[0];
    if (seen > kOccluded * inverse_z) {
      total += static_cast<double>(c.most);
      continue;
    }
    float value[kPatchSize], gx[kPatchSize], gy[kPatchSize];
    for (int k = 0; k < kPatchSize; ++k) {
      const int column = static_cast<int>(u[k]), row = static_cast<int>(v[k]);
      const float a = u[k] - static_cast<float>(column), b = v[k] - static_cast<float>(row);
      const cv::Vec4f* top = target.image[row] + column;
      const cv::Vec4f* bottom = target.image[row + 1] + column;
      const Vec4 s = (1 - b) * ((1 - a) * load(top[0]) + a * load(top[1])) +
                     b * ((1 - a) * load(bottom[0]) + a * load(bottom[1]));
      value[k] = s[0];
      gx[k] = s[1];
      gy[k] = s[2];
    }
    float lanes[kSums][kPatchSize];
    for (int k = 0; k < kPatchSize; ++k) {
      const float radiance = point.intensity[static_cast<std::size_t>(k)] - g.bias_host;
      const float r = (value[k] - g.gain * radiance - g.bias_target) * c.inverse_sigma;
      const float size = std::abs(r);
      const float inlier = std::min(size, c.huber);
      const float softness = point.softness[static_cast<std::size_t>(k)];
      const float w = softness * c.huber / std::max(size, c.huber);
      const float a = -radiance * g.inverse_host_gain;
      const float wx = w * gx[k], wy = w * gy[k], wa = w * a;
      lanes[kXX][k] = wx * gx[k];
      lanes[kXY][k] = wx * gy[k];
      lanes[kYY][k] = wy * gy[k];
      lanes[kXA][k] = wx * a;
      lanes[kYA][k] = wy * a;
      lanes[kX][k] = wx;
      lanes[kY][k] = wy;
      lanes[kAA][k] = wa * a;
      lanes[kA][k] = wa;
      lanes[kOne][k] = w;
      lanes[kXR][k] = wx * r;
      lanes[kYR][k] = wy * r;
      lanes[kAR][k] = wa * r;
      lanes[kR][k] = w * r;
      lanes[kCost][k] = softness * inlier * (size - 0.5F * inlier);
    }
    float sum[kSums];
    for (int s = 0; s < kSums; ++s) {
      const float* l = lanes[s];
      sum[s] = ((l[0] + l[4]) + (l[2] + l[6])) + ((l[1] + l[5]) + (l[3] + l[7]));
    }
    // Depth residual 1 / z - seen, where the target's depth is smooth.
    float cost = sum[kCost], depth_weight = 0;
    const float depth_error = inverse_z - seen;
    if (c.geometric > 0 && seen == seen) {
      const float bias = c.depth_bias * seen;
      const float variance = c.depth_variance + bias * bias;
      const float norm = std::abs(depth_error) / std::sqrt(variance);
      const float inlier = std::min(norm, kDepthHuber);
      cost += c.geometric * inlier * (norm - 0.5F * inlier);
      depth_weight = c.geometric / variance * kDepthHuber / std::max(norm, kDepthHuber);
    }
    if (!(cost <= c.most)) {
      total += static_cast<double>(c.most);
      continue;
    }
    total += static_cast<double>(cost);

    const float s = c.inverse_sigma, s2 = s * s;
    const float fx = c.fx, fy = c.fy, px = x[0], py = y[0];
    const float unit = -static_cast<float>(kBrightnessUnit);
    // d (u, v) / d xi at the centre; two zeros pad to the brightness columns.
    const float du[kN] = {
        fx * inverse_z, 0, -fx * px * inverse_z, -fx * px * py, fx * (1 + px * px), -fx * py, 0, 0};
    const float dv[kN] = {
        0, fy * inverse_z, -fy * py * inverse_z, -fy * (1 + py * py), fy * px * py, fy * px, 0, 0};
    float gu[kN], gv[kN];  // gradient-weighted columns of the Jacobian
    for (int j = 0; j < kN; ++j) {
      gu[j] = s2 * (sum[kXX] * du[j] + sum[kXY] * dv[j]);
      gv[j] = s2 * (sum[kXY] * du[j] + sum[kYY] * dv[j]);
    }
    gu[6] = s2 * sum[kXA];
    gu[7] = s2 * unit * sum[kX];
    gv[6] = s2 * sum[kYA];
    gv[7] = s2 * unit * sum[kY];
    // d (u, v) / d rho = f (t - (x, y) t_z) / q_z
    const float ru = fx * (t[0] - px * t[2]) * iz[0], rv = fy * (t[1] - py * t[2]) * iz[0];
    for (int a = 0; a < 6; ++a)
      for (int j = 0; j < kN; ++j)
        pair.hessian[static_cast<std::size_t>(a * kN + j)] += du[a] * gu[j] + dv[a] * gv[j];
    for (int j = 0; j < 6; ++j) {
      pair.hessian[static_cast<std::size_t>(6 * kN + j)] += du[j] * gu[6] + dv[j] * gv[6];
      pair.hessian[static_cast<std::size_t>(7 * kN + j)] += du[j] * gu[7] + dv[j] * gv[7];
    }
    pair.hessian[6 * kN + 6] += s2 * sum[kAA];
    pair.hessian[6 * kN + 7] += s2 * unit * sum[kA];
    pair.hessian[7 * kN + 6] += s2 * unit * sum[kA];
    pair.hessian[7 * kN + 7] += s2 * unit * unit * sum[kOne];
    for (int j = 0; j < kN; ++j) {
      pair.gradient[static_cast<std::size_t>(j)] += s * (sum[kXR] * du[j] + sum[kYR] * dv[j]);
      couple[j] = ru * gu[j] + rv * gv[j];
    }
    pair.gradient[6] += s * sum[kAR];
    pair.gradient[7] += s * unit * sum[kR];
    depths[i].gradient += s * (sum[kXR] * ru + sum[kYR] * rv);
    depths[i].curvature +=
        s2 * (ru * (sum[kXX] * ru + sum[kXY] * rv) + rv * (sum[kXY] * ru + sum[kYY] * rv));

    // 1 / z of the point: d / d xi = -1/z^2 (0, 0, 1, y z, -x z, 0), d / d rho as below.
    const float jz[3] = {-inverse_z * inverse_z, -inverse_z * py, inverse_z * px};
    const float jr = (1 - tz * iz[0]) * iz[0];
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b)
        pair.hessian[static_cast<std::size_t>((a + 2) * kN + b + 2)] +=
            depth_weight * jz[a] * jz[b];
      const float error = depth_weight > 0 ? depth_error : 0;
      pair.gradient[static_cast<std::size_t>(a + 2)] += depth_weight * jz[a] * error;
      couple[a + 2] += depth_weight * jr * jz[a];
    }
    depths[i].gradient += depth_weight > 0 ? depth_weight * jr * depth_error : 0;
    depths[i].curvature += depth_weight * jr * jr;
  }
  return total;
}

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
  const float huber = static_cast<float>(options.huber);
  const double noise = options.depth_noise;
  const Constants constants{.fx = static_cast<float>(camera.fx),
                            .fy = static_cast<float>(camera.fy),
                            .cx = static_cast<float>(camera.cx),
                            .cy = static_cast<float>(camera.cy),
                            .limit_u = static_cast<float>(camera.width) - 1 - kMargin,
                            .limit_v = static_cast<float>(camera.height) - 1 - kMargin,
                            .inverse_sigma = static_cast<float>(1 / options.sigma),
                            .huber = huber,
                            .most = huber * (kSaturation - 0.5F * huber) * kPatchSize,
                            .geometric = static_cast<float>(options.geometric),
                            .depth_variance = static_cast<float>(2 * noise * noise),
                            .depth_bias = static_cast<float>(options.depth_bias)};
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
