// SPDX-License-Identifier: MIT
#include "edvo/track/window.hpp"

#include "edvo/track/bilinear.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr int kBlock = 8;  // unknowns of a keyframe: xi, gain, bias
constexpr std::array<std::array<int, 2>, kPatchSize> kPattern = {
    {{0, 0}, {0, -2}, {-1, -1}, {1, -1}, {-2, 0}, {2, 0}, {-1, 1}, {0, 2}}};
constexpr double kBrightnessUnit = 64.0;  // [grey levels]

using Row = Eigen::Matrix<double, 1, 6>;
using Block = Eigen::Matrix<double, kBlock, kBlock>;
using BlockVector = Eigen::Matrix<double, kBlock, 1>;

cv::Vec4f sample(const cv::Mat_<cv::Vec4f>& image, float u, float v) {
  const int x = static_cast<int>(u), y = static_cast<int>(v);
  const float a = u - static_cast<float>(x), b = v - static_cast<float>(y);
  const cv::Vec4f* top = image[y] + x;
  const cv::Vec4f* bottom = image[y + 1] + x;
  const float w00 = (1 - a) * (1 - b), w10 = a * (1 - b), w01 = (1 - a) * b, w11 = a * b;
  cv::Vec4f out;
  for (int k = 0; k < 4; ++k)
    out[k] = w00 * top[0][k] + w10 * top[1][k] + w01 * bottom[0][k] + w11 * bottom[1][k];
  return out;
}

struct Problem {
  std::vector<WindowKeyframe>& window;
  const Camera& camera;
  const WindowOptions& options;
  int fixed;
  int unknowns;
};

struct Linearization {
  Eigen::MatrixXd hessian;      // points eliminated
  Eigen::VectorXd gradient;
  std::vector<std::vector<Eigen::VectorXd>> cross;   // per point: d^2 cost / d pose d depth
  std::vector<std::vector<std::array<double, 2>>> depth;  // per point: gradient, curvature
  double cost = 0;
};

// One host-target pair's contribution of one point, over (xi relative, target gain, bias,
// host gain, bias is folded in) and depth.
Linearization linearize(const Problem& p) {
  const int count = static_cast<int>(p.window.size());
  const int n = kBlock * count;
  Linearization out;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  out.cross.resize(p.window.size());
  out.depth.resize(p.window.size());
  const float fx = static_cast<float>(p.camera.fx), fy = static_cast<float>(p.camera.fy);
  const float cx = static_cast<float>(p.camera.cx), cy = static_cast<float>(p.camera.cy);
  const float inverse_sigma = static_cast<float>(1.0 / p.options.sigma);
  const float huber = static_cast<float>(p.options.huber);
  const float limit_u = static_cast<float>(p.camera.width - 4);
  const float limit_v = static_cast<float>(p.camera.height - 4);
  constexpr float kSaturation = 6.F;  // [sigmas]: what a patch out of view or occluded pays per pixel
  const float saturated = huber * (kSaturation - 0.5F * huber);

  for (int h = 0; h < count; ++h) {
    const WindowKeyframe& host = p.window[static_cast<std::size_t>(h)];
    out.cross[static_cast<std::size_t>(h)].assign(host.points.size(), Eigen::VectorXd());
    out.depth[static_cast<std::size_t>(h)].assign(host.points.size(), {0, 0});
    std::vector<Matrix6d> adjoints(static_cast<std::size_t>(count));
    std::vector<SE3> target_from_host(static_cast<std::size_t>(count));
    for (int t = 0; t < count; ++t) {
      target_from_host[static_cast<std::size_t>(t)] =
          inverse(p.window[static_cast<std::size_t>(t)].world_from_key) * host.world_from_key;
      adjoints[static_cast<std::size_t>(t)] = adjoint(target_from_host[static_cast<std::size_t>(t)]);
    }
    // relative blocks: (xi_rel 6, gain_t, bias_t, gain_h, bias_h)
    using Rel = Eigen::Matrix<double, 10, 10>;
    using RelVector = Eigen::Matrix<double, 10, 1>;
    std::vector<Rel> rel(static_cast<std::size_t>(count), Rel::Zero());
    std::vector<RelVector> rel_b(static_cast<std::size_t>(count), RelVector::Zero());

    for (std::size_t i = 0; i < host.points.size(); ++i) {
      const WindowPoint& point = host.points[i];
      const float rho = static_cast<float>(point.inverse_depth);
      Eigen::VectorXd cross = Eigen::VectorXd::Zero(n);
      const double prior_error = point.inverse_depth - point.measured;
      double g_depth = point.weight * prior_error, h_depth = point.weight;
      out.cost += 0.5 * point.weight * prior_error * prior_error;
      for (int t = 0; t < count; ++t) {
        if (t == h || (t < p.fixed && h < p.fixed)) continue;
        const WindowKeyframe& target = p.window[static_cast<std::size_t>(t)];
        const SE3& T = target_from_host[static_cast<std::size_t>(t)];
        const Eigen::Matrix3f R = T.rotation.toRotationMatrix().cast<float>();
        const Eigen::Vector3f tr = T.translation.cast<float>();
        const float gain = static_cast<float>(target.gain / host.gain);
        const float bias_t = static_cast<float>(target.bias), bias_h = static_cast<float>(host.bias);
        Eigen::Matrix<float, 10, 10> Hf = Eigen::Matrix<float, 10, 10>::Zero();
        Eigen::Matrix<float, 10, 1> bf = Eigen::Matrix<float, 10, 1>::Zero(), cf = bf;
        float gd = 0, hd = 0, cost = 0;
        bool visible = true;
        for (int k = 0; k < kPatchSize && visible; ++k) {
          const auto kk = static_cast<std::size_t>(k);
          const Eigen::Vector3f ray((point.u + static_cast<float>(kPattern[kk][0]) - cx) / fx,
                                    (point.v + static_cast<float>(kPattern[kk][1]) - cy) / fy, 1.F);
          const Eigen::Vector3f q = R * ray + rho * tr;  // p_target * rho
          if (q.z() < 0.05F) { visible = false; break; }
          const float iz = 1.F / q.z();
          const float x = q.x() * iz, y = q.y() * iz;
          const float u = fx * x + cx, v = fy * y + cy;
          if (!(u >= 3 && v >= 3 && u < limit_u && v < limit_v)) { visible = false; break; }
          const float z = q.z() / rho;
          if (k == 0) {
            const float seen = target.inverse_depth(static_cast<int>(v + 0.5F), static_cast<int>(u + 0.5F));
            if (!std::isnan(seen) && seen * z > 1.10F) { visible = false; break; }  // occluded
            if (!std::isnan(seen) && p.options.geometric > 0) {
              // depth residual: 1 / z - seen
              const double e = 1.0 / static_cast<double>(z) - static_cast<double>(seen);
              const double sigma2 = 2 * p.options.depth_noise * p.options.depth_noise +
                                    p.options.depth_bias * p.options.depth_bias * static_cast<double>(seen * seen);
              double w = p.options.geometric / sigma2;
              const double norm = std::abs(e) / std::sqrt(sigma2);
              double c = 0.5 * w * e * e;
              if (norm > 2) { c = p.options.geometric * 2 * (norm - 1); w *= 2 / norm; }
              cost += static_cast<float>(c);
              const float jz = -1.F / (z * z);
              Eigen::Matrix<float, 10, 1> J = Eigen::Matrix<float, 10, 1>::Zero();
              // d z / d xi = [0 0 1 | p x e_z]: (y, -x, 0) * z
              J[2] = jz; J[3] = jz * y * z; J[4] = -jz * x * z;
              // z = q.z / rho ; q.z = (R ray).z + rho t.z -> 1/z = rho / q.z; d/drho = (q.z - rho t.z)/q.z^2
              const float jd = (q.z() - rho * tr.z()) * iz * iz;
              const float wf = static_cast<float>(w), ef = static_cast<float>(e);
              Hf += wf * J * J.transpose(); bf += wf * ef * J; cf += wf * jd * J;
              gd += wf * ef * jd; hd += wf * jd * jd;
            }
          }
          const cv::Vec4f s = sample(target.image, u, v);
          const float expected = gain * (point.intensity[kk] - bias_h) + bias_t;
          const float r = (s[0] - expected) * inverse_sigma;
          const float a = std::abs(r);
          float w = point.softness[kk];
          cost += w * (a <= huber ? 0.5F * r * r : huber * (a - 0.5F * huber));
          w *= a <= huber ? 1.F : huber / a;
          const float gx = s[1] * fx * inverse_sigma, gy = s[2] * fy * inverse_sigma;
          const float riz = rho * iz;  // 1 / z
          Eigen::Matrix<float, 10, 1> J;
          J[0] = gx * riz; J[1] = gy * riz; J[2] = -(gx * x + gy * y) * riz;
          J[3] = -gx * x * y - gy * (1 + y * y);
          J[4] = gx * (1 + x * x) + gy * x * y;
          J[5] = -gx * y + gy * x;
          const float radiance = (point.intensity[kk] - bias_h);
          const float unit = static_cast<float>(kBrightnessUnit);
          J[6] = -radiance * inverse_sigma / static_cast<float>(host.gain);
          J[7] = -unit * inverse_sigma;
          J[8] = gain * radiance * inverse_sigma / static_cast<float>(host.gain);
          J[9] = gain * unit * inverse_sigma;
          // d (x, y) / d rho = (t - (x, y) t.z) / q.z
          const float jd = (gx * (tr.x() - x * tr.z()) + gy * (tr.y() - y * tr.z())) * iz;
          Hf.noalias() += (w * J) * J.transpose();
          bf.noalias() += (w * r) * J;
          cf.noalias() += (w * jd) * J;
          gd += w * r * jd;
          hd += w * jd * jd;
        }
        const float most = saturated * kPatchSize;
        if (!visible || cost > most) {
          out.cost += static_cast<double>(most);
          continue;
        }
        out.cost += static_cast<double>(cost);
        g_depth += static_cast<double>(gd);
        h_depth += static_cast<double>(hd);
        const auto tt = static_cast<std::size_t>(t);
        rel[tt] += Hf.cast<double>();
        rel_b[tt] += bf.cast<double>();
        const RelVector c = cf.cast<double>();
        cross.segment<6>(kBlock * h) += adjoints[tt].transpose() * c.head<6>();
        cross.segment<6>(kBlock * t) -= c.head<6>();
        cross.segment<2>(kBlock * t + 6) += c.segment<2>(6);
        cross.segment<2>(kBlock * h + 6) += c.segment<2>(8);
      }
      out.depth[static_cast<std::size_t>(h)][i] = {g_depth, h_depth};
      H.noalias() -= (cross / h_depth) * cross.transpose();
      b.noalias() -= cross * (g_depth / h_depth);
      out.cross[static_cast<std::size_t>(h)][i] = std::move(cross);
    }
    for (int t = 0; t < count; ++t) {
      if (t == h) continue;
      Eigen::MatrixXd A = Eigen::MatrixXd::Zero(10, n);  // relative unknowns from all
      A.block<6, 6>(0, kBlock * h) = adjoints[static_cast<std::size_t>(t)];
      A.block<6, 6>(0, kBlock * t) = -Matrix6d::Identity();
      A(6, kBlock * t + 6) = A(7, kBlock * t + 7) = 1;
      A(8, kBlock * h + 6) = A(9, kBlock * h + 7) = 1;
      H.noalias() += A.transpose() * rel[static_cast<std::size_t>(t)] * A;
      b.noalias() += A.transpose() * rel_b[static_cast<std::size_t>(t)];
    }
  }
  for (int k = 0; k < count; ++k) {  // brightness prior
    const WindowKeyframe& key = p.window[static_cast<std::size_t>(k)];
    const double wg = 1 / (0.3 * 0.3), wb = kBrightnessUnit * kBrightnessUnit / (30. * 30.);
    const double eg = key.gain - 1, eb = key.bias / kBrightnessUnit;
    H(kBlock * k + 6, kBlock * k + 6) += wg;
    H(kBlock * k + 7, kBlock * k + 7) += wb;
    b[kBlock * k + 6] += wg * eg;
    b[kBlock * k + 7] += wb * eb;
    out.cost += 0.5 * (wg * eg * eg + wb * eb * eb);
  }
  out.hessian = std::move(H);
  out.gradient = std::move(b);
  return out;
}

void apply(Problem& p, const Linearization& system, const Eigen::VectorXd& step) {
  for (std::size_t h = 0; h < p.window.size(); ++h) {
    WindowKeyframe& key = p.window[h];
    const auto d = step.segment<kBlock>(kBlock * static_cast<int>(h));
    const Vector6d xi = d.head<6>();
    key.world_from_key = key.world_from_key * exp(xi);
    key.gain += d[6];
    key.bias += kBrightnessUnit * d[7];
    for (std::size_t i = 0; i < key.points.size(); ++i) {
      const auto& [g, curvature] = system.depth[h][i];
      const double change = -(g + system.cross[h][i].dot(step)) / curvature;
      WindowPoint& point = key.points[i];
      point.inverse_depth = std::clamp(point.inverse_depth + change, 0.5 * point.measured, 2 * point.measured);
    }
  }
}

}  // namespace

WindowKeyframe make_window_keyframe(const Frame& frame, const SE3& world_from_key,
                                    const std::vector<SelectedPixel>& pixels,
                                    const WindowOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  WindowKeyframe key{.world_from_key = world_from_key};
  key.image.create(gray.size());
  for (int y = 0; y < gray.rows; ++y) {
    const std::uint8_t* above = gray[std::max(y - 1, 0)];
    const std::uint8_t* row = gray[y];
    const std::uint8_t* below = gray[std::min(y + 1, gray.rows - 1)];
    cv::Vec4f* out = key.image[y];
    for (int x = 0; x < gray.cols; ++x) {
      const int left = std::max(x - 1, 0), right = std::min(x + 1, gray.cols - 1);
      out[x] = {static_cast<float>(row[x]), 0.5F * static_cast<float>(row[right] - row[left]),
                0.5F * static_cast<float>(below[x] - above[x]), 0.F};
    }
  }
  constexpr float kJump = 0.03F;
  key.inverse_depth = cv::Mat_<float>(gray.size(), std::numeric_limits<float>::quiet_NaN());
  for (int y = 2; y < gray.rows - 2; ++y)
    for (int x = 2; x < gray.cols - 2; ++x) {
      const float z = frame.depth(y, x);
      bool smooth = true;
      for (const auto& [dx, dy] : {std::pair{-2, 0}, {2, 0}, {0, -2}, {0, 2}})
        smooth = smooth && std::abs(frame.depth(y + dy, x + dx) - z) < kJump * z;
      if (smooth) key.inverse_depth(y, x) = 1.F / z;
    }
  const float soft2 = static_cast<float>(options.softness * options.softness);
  for (const SelectedPixel& selected : pixels) {
    WindowPoint point{.u = static_cast<float>(selected.pixel.x),
                      .v = static_cast<float>(selected.pixel.y)};
    point.measured = point.inverse_depth = 1.0 / static_cast<double>(selected.depth);
    const double bias = options.depth_bias * point.measured;
    point.weight = 1.0 / (options.depth_noise * options.depth_noise + bias * bias);
    for (std::size_t k = 0; k < kPatchSize; ++k) {
      const cv::Vec4f s = key.image(selected.pixel.y + kPattern[k][1], selected.pixel.x + kPattern[k][0]);
      point.intensity[k] = s[0];
      point.softness[k] = soft2 / (soft2 + s[1] * s[1] + s[2] * s[2]);
    }
    key.points.push_back(point);
  }
  return key;
}

WindowSummary refine_window(std::vector<WindowKeyframe>& window, const Camera& camera, int fixed,
                            const WindowOptions& options) {
  const int count = static_cast<int>(window.size());
  fixed = std::min(fixed, count - 1);
  Problem problem{window, camera, options, fixed, kBlock * (count - fixed)};
  if (count < 2) return {};
  Linearization system = linearize(problem);
  WindowSummary summary{1, system.cost, system.cost};
  double lambda = 1e-4;
  const int first = kBlock * fixed, size = kBlock * (count - fixed);
  while (summary.iterations < options.iterations) {
    Eigen::MatrixXd H = system.hessian.block(first, first, size, size);
    H.diagonal() *= 1 + lambda;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(kBlock * count);
    step.segment(first, size) = -H.ldlt().solve(system.gradient.segment(first, size));
    if (!step.allFinite()) break;
    const std::vector<WindowKeyframe> before = window;
    apply(problem, system, step);
    Linearization next = linearize(problem);
    ++summary.iterations;
    if (next.cost < system.cost) {
      const double gained = system.cost - next.cost;
      system = std::move(next);
      summary.last_cost = system.cost;
      lambda = std::max(1e-7, lambda * 0.25);
      if (gained < 1e-4 * system.cost) break;
    } else {
      window = before;
      lambda *= 16;
    }
  }
  return summary;
}

}  // namespace edvo
