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

// A host-target pair sees the relative twist of the host and the target's gain and bias; the host's
// gain and bias act through the same two columns.
using PairVector = Eigen::Matrix<float, kBlock, 1>;
using PairMatrix = Eigen::Matrix<float, kBlock, kBlock>;

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
  const Camera& camera;
  const WindowOptions& options;
  int fixed;
};

// What one point adds: its own unknown, and its coupling with each target's pair unknowns.
struct PointSystem {
  double gradient = 0, curvature = 0;
};

struct HostSystem {
  std::vector<PointSystem> points;
  std::vector<PairVector> coupling;  // points x targets, d^2 cost / d pair d inverse depth
  Eigen::MatrixXd pair_from_window;  // (8 targets) x (8 keyframes)
};

struct Linearization {
  Eigen::MatrixXd hessian;   // inverse depths eliminated
  Eigen::VectorXd gradient;
  std::vector<HostSystem> hosts;
  double cost = 0;
};

struct PairSystem {
  PairMatrix hessian = PairMatrix::Zero();
  PairVector gradient = PairVector::Zero();
  PairVector coupling = PairVector::Zero();
  float depth_gradient = 0, depth_curvature = 0;
  float cost = 0;
};

struct PairGeometry {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  float gain;              // target from host
  float bias_host, bias_target;
  float radiance_per_gain; // 1 / host gain
};

// Residuals of one patch in one target. False where it is not seen.
bool add_patch(const Problem& p, const PairGeometry& g, const WindowPoint& point,
               const WindowKeyframe& target, PairSystem& out) {
  const float fx = static_cast<float>(p.camera.fx), fy = static_cast<float>(p.camera.fy);
  const float cx = static_cast<float>(p.camera.cx), cy = static_cast<float>(p.camera.cy);
  const float inverse_sigma = static_cast<float>(1.0 / p.options.sigma);
  const float huber = static_cast<float>(p.options.huber);
  const float limit_u = static_cast<float>(p.camera.width - 4);
  const float limit_v = static_cast<float>(p.camera.height - 4);
  const float rho = static_cast<float>(point.inverse_depth);
  for (std::size_t k = 0; k < kPatchSize; ++k) {
    const Eigen::Vector3f ray((point.u + static_cast<float>(kPattern[k][0]) - cx) / fx,
                              (point.v + static_cast<float>(kPattern[k][1]) - cy) / fy, 1.F);
    const Eigen::Vector3f q = g.rotation * ray + rho * g.translation;  // rho * (point in target)
    if (q.z() < 0.05F) return false;
    const float iz = 1.F / q.z();
    const float x = q.x() * iz, y = q.y() * iz;
    const float u = fx * x + cx, v = fy * y + cy;
    if (!(u >= 3 && v >= 3 && u < limit_u && v < limit_v)) return false;
    if (k == 0) {
      const float z = q.z() / rho;
      const float seen =
          target.inverse_depth(static_cast<int>(v + 0.5F), static_cast<int>(u + 0.5F));
      if (seen * z > 1.10F) return false;  // something stands in front
      if (!std::isnan(seen) && p.options.geometric > 0) {
        const float geometric = static_cast<float>(p.options.geometric);
        const float noise = static_cast<float>(p.options.depth_noise);
        const float bias = static_cast<float>(p.options.depth_bias) * seen;
        const float variance = 2 * noise * noise + bias * bias;
        const float e = 1.F / z - seen;
        const float norm = std::abs(e) / std::sqrt(variance);
        constexpr float kThreshold = 2.F;
        const bool inlier = norm <= kThreshold;
        out.cost += geometric * (inlier ? 0.5F * norm * norm : kThreshold * (norm - 0.5F * kThreshold));
        const float w = geometric / variance * (inlier ? 1.F : kThreshold / norm);
        PairVector J = PairVector::Zero();
        const float jz = -1.F / (z * z);
        J[2] = jz;
        J[3] = jz * y * z;
        J[4] = -jz * x * z;
        const float jd = (q.z() - rho * g.translation.z()) * iz * iz;
        out.hessian += (w * J) * J.transpose();
        out.gradient += w * e * J;
        out.coupling += w * jd * J;
        out.depth_gradient += w * e * jd;
        out.depth_curvature += w * jd * jd;
      }
    }
    const cv::Vec4f s = sample(target.image, u, v);
    const float radiance = point.intensity[k] - g.bias_host;
    const float r = (s[0] - g.gain * radiance - g.bias_target) * inverse_sigma;
    const float a = std::abs(r);
    float w = point.softness[k];
    out.cost += w * (a <= huber ? 0.5F * r * r : huber * (a - 0.5F * huber));
    w *= a <= huber ? 1.F : huber / a;
    const float gx = s[1] * fx * inverse_sigma, gy = s[2] * fy * inverse_sigma;
    const float riz = rho * iz;  // 1 / z
    PairVector J;
    J << gx * riz, gy * riz, -(gx * x + gy * y) * riz, -gx * x * y - gy * (1 + y * y),
        gx * (1 + x * x) + gy * x * y, gy * x - gx * y,
        -radiance * g.radiance_per_gain * inverse_sigma,
        -static_cast<float>(kBrightnessUnit) * inverse_sigma;
    const float jd =
        (gx * (g.translation.x() - x * g.translation.z()) +
         gy * (g.translation.y() - y * g.translation.z())) * iz;
    out.hessian.noalias() += (w * J) * J.transpose();
    out.gradient.noalias() += (w * r) * J;
    out.coupling.noalias() += (w * jd) * J;
    out.depth_gradient += w * r * jd;
    out.depth_curvature += w * jd * jd;
  }
  return true;
}

Linearization linearize(const Problem& p, const std::vector<WindowKeyframe>& window) {
  const int count = static_cast<int>(window.size());
  const int n = kBlock * count;
  const float huber = static_cast<float>(p.options.huber);
  constexpr float kSaturation = 6.F;  // [sigmas] of a patch out of view, occluded or not matching
  const float most = huber * (kSaturation - 0.5F * huber) * kPatchSize;

  Linearization out{.hessian = Eigen::MatrixXd::Zero(n, n), .gradient = Eigen::VectorXd::Zero(n)};
  out.hosts.resize(window.size());
  for (int h = 0; h < count; ++h) {
    const WindowKeyframe& host = window[static_cast<std::size_t>(h)];
    HostSystem& system = out.hosts[static_cast<std::size_t>(h)];
    system.points.resize(host.points.size());
    system.coupling.assign(host.points.size() * window.size(), PairVector::Zero());
    system.pair_from_window = Eigen::MatrixXd::Zero(n, n);
    std::vector<PairGeometry> geometry(window.size());
    for (int t = 0; t < count; ++t) {
      const WindowKeyframe& target = window[static_cast<std::size_t>(t)];
      const SE3 target_from_host = inverse(target.world_from_key) * host.world_from_key;
      const double gain = target.gain / host.gain;
      geometry[static_cast<std::size_t>(t)] = {
          .rotation = target_from_host.rotation.toRotationMatrix().cast<float>(),
          .translation = target_from_host.translation.cast<float>(),
          .gain = static_cast<float>(gain),
          .bias_host = static_cast<float>(host.bias),
          .bias_target = static_cast<float>(target.bias),
          .radiance_per_gain = static_cast<float>(1 / host.gain)};
      if (t == h) continue;
      auto A = system.pair_from_window.middleRows<kBlock>(kBlock * t);
      A.block<6, 6>(0, kBlock * h) = adjoint(target_from_host);
      A.block<6, 6>(0, kBlock * t) = -Matrix6d::Identity();
      A.block<2, 2>(6, kBlock * t + 6) = Eigen::Matrix2d::Identity();
      A.block<2, 2>(6, kBlock * h + 6) = -gain * Eigen::Matrix2d::Identity();
    }
    Eigen::MatrixXf pairs = Eigen::MatrixXf::Zero(n, n);
    Eigen::VectorXf pairs_gradient = Eigen::VectorXf::Zero(n);
    std::vector<int> seen_in;
    for (std::size_t i = 0; i < host.points.size(); ++i) {
      const WindowPoint& point = host.points[i];
      PairVector* coupling = &system.coupling[i * window.size()];
      const double error = point.inverse_depth - point.measured;
      PointSystem own{.gradient = point.weight * error, .curvature = point.weight};
      out.cost += 0.5 * point.weight * error * error;
      seen_in.clear();
      for (int t = 0; t < count; ++t) {
        if (t == h || (t < p.fixed && h < p.fixed)) continue;
        const auto tt = static_cast<std::size_t>(t);
        PairSystem pair;
        if (!add_patch(p, geometry[tt], point, window[tt], pair) || pair.cost > most) {
          out.cost += static_cast<double>(most);
          continue;
        }
        out.cost += static_cast<double>(pair.cost);
        own.gradient += static_cast<double>(pair.depth_gradient);
        own.curvature += static_cast<double>(pair.depth_curvature);
        pairs.block<kBlock, kBlock>(kBlock * t, kBlock * t) += pair.hessian;
        pairs_gradient.segment<kBlock>(kBlock * t) += pair.gradient;
        coupling[t] = pair.coupling;
        seen_in.push_back(t);
      }
      const float inverse_curvature = static_cast<float>(1 / own.curvature);
      const float relative = static_cast<float>(own.gradient / own.curvature);
      for (const int a : seen_in) {
        pairs_gradient.segment<kBlock>(kBlock * a) -= relative * coupling[a];
        const PairVector scaled = inverse_curvature * coupling[a];
        for (const int b : seen_in)
          pairs.block<kBlock, kBlock>(kBlock * a, kBlock * b).noalias() -=
              scaled * coupling[b].transpose();
      }
      system.points[i] = own;
    }
    const Eigen::MatrixXd& A = system.pair_from_window;
    out.hessian.noalias() += A.transpose() * pairs.cast<double>() * A;
    out.gradient.noalias() += A.transpose() * pairs_gradient.cast<double>();
  }
  for (int k = 0; k < count; ++k) {  // brightness prior
    const WindowKeyframe& key = window[static_cast<std::size_t>(k)];
    const double wg = 1 / (0.3 * 0.3), wb = kBrightnessUnit * kBrightnessUnit / (30. * 30.);
    const double eg = key.gain - 1, eb = key.bias / kBrightnessUnit;
    out.hessian(kBlock * k + 6, kBlock * k + 6) += wg;
    out.hessian(kBlock * k + 7, kBlock * k + 7) += wb;
    out.gradient[kBlock * k + 6] += wg * eg;
    out.gradient[kBlock * k + 7] += wb * eb;
    out.cost += 0.5 * (wg * eg * eg + wb * eb * eb);
  }
  return out;
}

cv::Mat_<cv::Vec4f> with_gradient(const cv::Mat_<std::uint8_t>& gray) {
  cv::Mat_<cv::Vec4f> image(gray.size());
  for (int y = 0; y < gray.rows; ++y) {
    const std::uint8_t* above = gray[std::max(y - 1, 0)];
    const std::uint8_t* row = gray[y];
    const std::uint8_t* below = gray[std::min(y + 1, gray.rows - 1)];
    cv::Vec4f* out = image[y];
    for (int x = 0; x < gray.cols; ++x) {
      const int left = std::max(x - 1, 0), right = std::min(x + 1, gray.cols - 1);
      out[x] = {static_cast<float>(row[x]), 0.5F * static_cast<float>(row[right] - row[left]),
                0.5F * static_cast<float>(below[x] - above[x]), 0.F};
    }
  }
  return image;
}

void apply(const Linearization& system, const Eigen::VectorXd& step,
           std::vector<WindowKeyframe>& window) {
  for (std::size_t h = 0; h < window.size(); ++h) {
    WindowKeyframe& key = window[h];
    const auto d = step.segment<kBlock>(kBlock * static_cast<int>(h));
    const Vector6d xi = d.head<6>();
    key.world_from_key = key.world_from_key * exp(xi);
    key.gain += d[6];
    key.bias += kBrightnessUnit * d[7];
    const HostSystem& host = system.hosts[h];
    const Eigen::VectorXf pair_step = (host.pair_from_window * step).cast<float>();
    for (std::size_t i = 0; i < key.points.size(); ++i) {
      float coupled = 0;
      for (std::size_t t = 0; t < window.size(); ++t)
        coupled += host.coupling[i * window.size() + t].dot(
            pair_step.segment<kBlock>(kBlock * static_cast<int>(t)));
      const auto& [gradient, curvature] = host.points[i];
      const double change = -(gradient + static_cast<double>(coupled)) / curvature;
      WindowPoint& point = key.points[i];
      point.inverse_depth =
          std::clamp(point.inverse_depth + change, 0.5 * point.measured, 2 * point.measured);
    }
  }
}

}  // namespace

WindowKeyframe make_window_keyframe(const Frame& frame, const SE3& world_from_key,
                                    const std::vector<SelectedPixel>& pixels,
                                    const WindowOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  WindowKeyframe key{.world_from_key = world_from_key};
  key.gray = gray;
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
      const int x = selected.pixel.x + kPattern[k][0], y = selected.pixel.y + kPattern[k][1];
      const float gx = 0.5F * static_cast<float>(gray(y, x + 1) - gray(y, x - 1));
      const float gy = 0.5F * static_cast<float>(gray(y + 1, x) - gray(y - 1, x));
      point.intensity[k] = gray(y, x);
      point.softness[k] = soft2 / (soft2 + gx * gx + gy * gy);
    }
    key.points.push_back(point);
  }
  return key;
}

double shared_view(const WindowKeyframe& host, const WindowKeyframe& target,
                   const Camera& camera) {
  const SE3 target_from_host = inverse(target.world_from_key) * host.world_from_key;
  int seen = 0, tried = 0;
  for (std::size_t i = 0; i < host.points.size(); i += 5) {
    const WindowPoint& point = host.points[i];
    const double z = 1 / point.inverse_depth;
    const Eigen::Vector3d x = target_from_host * back_project(camera, point.u, point.v, z);
    ++tried;
    if (x.z() < 0.5 * z || x.z() > 2 * z) continue;  // too different in scale to match patches
    const Eigen::Vector2d pixel = project(camera, x);
    seen += pixel.x() > 3 && pixel.y() > 3 && pixel.x() < camera.width - 4 &&
            pixel.y() < camera.height - 4;
  }
  return tried > 0 ? static_cast<double>(seen) / tried : 0.0;
}

WindowSummary refine_window(std::vector<WindowKeyframe>& window, const Camera& camera, int fixed,
                            const WindowOptions& options) {
  const int count = static_cast<int>(window.size());
  fixed = std::min(fixed, count - 1);
  if (count < 2) return {};
  for (WindowKeyframe& key : window)
    if (key.image.empty()) key.image = with_gradient(key.gray);
  const Problem problem{camera, options, fixed};
  Linearization system = linearize(problem, window);
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
    apply(system, step, window);
    Linearization next = linearize(problem, window);
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
