// SPDX-License-Identifier: MIT
#include "edvo/track/tracker.hpp"

#include "edvo/track/bilinear.hpp"
#include "edvo/track/levenberg_marquardt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;

constexpr float kOutside = std::numeric_limits<float>::quiet_NaN();
constexpr float kIntensityUnit = 64.F;  // [grey levels] makes gain and bias steps of like size
constexpr double kGainSigma = 0.3;      // prior: exposure rarely jumps by more
constexpr double kBiasSigma = 30.0;     // [grey levels]
constexpr float kInlierSigmas = 3.F;
// Neighbours on an edge share the errors of its depth and of interpolation: so many residuals tell
// as much as one that is independent (measured, docs/evaluation.md).
constexpr double kSharedError = 20.0;
constexpr float kSurfaceTukey = 6.F;  // [sigmas] farther off, it is another surface
constexpr float kSurfaceSaturation = kSurfaceTukey * kSurfaceTukey / 6.F;

// xi, gain, bias / kIntensityUnit.
using System = LinearSystem<8>;

// Residuals I_current(pi(T p)) - gain I_reference - bias of every point; NaN where out of view.
void residuals(const ReferenceLevel& reference, const Level& current, const Alignment& alignment,
               std::vector<float>& out) {
  const Eigen::Matrix3f R = alignment.cur_from_ref.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = alignment.cur_from_ref.translation.cast<float>();
  const float fx = static_cast<float>(current.camera.fx),
              fy = static_cast<float>(current.camera.fy);
  const float cx = static_cast<float>(current.camera.cx),
              cy = static_cast<float>(current.camera.cy);
  const float gain = static_cast<float>(alignment.gain), bias = static_cast<float>(alignment.bias);
  const std::size_t n = reference.x.size();
  out.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float px = reference.x[i], py = reference.y[i], pz = reference.z[i];
    const float x = R(0, 0) * px + R(0, 1) * py + R(0, 2) * pz + t.x();
    const float y = R(1, 0) * px + R(1, 1) * py + R(1, 2) * pz + t.y();
    const float z = R(2, 0) * px + R(2, 1) * py + R(2, 2) * pz + t.z();
    const float inverse_z = 1.F / z;
    const float u = fx * x * inverse_z + cx, v = fy * y * inverse_z + cy;
    const bool visible = z > 0.05F && inside(current.gray, u, v, 1);
    out[i] =
        visible ? bilinear(current.gray, u, v) - gain * reference.intensity[i] - bias : kOutside;
  }
}

// One pyramid level as a least-squares problem with a fixed scale of the residuals.
class LevelProblem {
 public:
  LevelProblem(const Reference& reference, const Frame& frame, std::size_t level,
               const TrackOptions& options, float sigma)
      : reference_(reference.levels[level]),
        surface_(reference.surface),
        current_(frame.levels[level]),
        full_camera_(frame.levels.front().camera),
        depth_(frame.depth),
        options_(options),
        sigma_(sigma) {}

  [[nodiscard]] System linearize(const Alignment& alignment) const {
    residuals(reference_, current_, alignment, residuals_);
    const Loss loss = options_.loss;
    const float k = static_cast<float>(options_.loss_parameter);
    const float inverse_sigma = 1.F / sigma_;
    // Points that leave the image keep paying the saturated loss, otherwise the best pose is one
    // that sees nothing.
    const float outside_cost = robust(loss, k, kInlierSigmas).cost;
    const float gain = static_cast<float>(alignment.gain);
    System system;
    Eigen::Matrix<float, 8, 8> hessian = Eigen::Matrix<float, 8, 8>::Zero();
    Eigen::Matrix<float, 8, 1> gradient = Eigen::Matrix<float, 8, 1>::Zero();
    float cost = 0;
    constexpr std::size_t kBlock = 256;  // sums of floats stay short, sums of blocks are double
    const std::size_t n = residuals_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const float r = residuals_[i];
      if (std::isnan(r)) {
        cost += outside_cost * reference_.weight[i];
      } else {
        const RobustValue value = robust(loss, k, r * inverse_sigma);
        cost += value.cost * reference_.weight[i];
        const float w = value.weight * reference_.weight[i] * inverse_sigma * inverse_sigma;
        Eigen::Matrix<float, 8, 1> J;
        for (int d = 0; d < 6; ++d)
          J[d] = gain * reference_.jacobian[static_cast<std::size_t>(d)][i];
        J[6] = -reference_.intensity[i];
        J[7] = -kIntensityUnit;
        hessian.noalias() += (w * J) * J.transpose();
        gradient.noalias() += (w * r) * J;
      }
      if (i % kBlock == kBlock - 1 || i + 1 == n) {
        system.hessian += hessian.cast<double>();
        system.gradient += gradient.cast<double>();
        system.cost += cost;
        hessian.setZero();
        gradient.setZero();
        cost = 0;
      }
    }
    if (options_.geometric > 0) add_surface(alignment.cur_from_ref, system);
    add_brightness_prior(alignment, system);
    return system;
  }

  [[nodiscard]] Alignment update(const Alignment& alignment, const Vector8d& step) const {
    return {.cur_from_ref = alignment.cur_from_ref * exp(step.head<6>()),
            .gain = alignment.gain + step[6],
            .bias = alignment.bias + kIntensityUnit * step[7]};
  }

  // Pixels that a step moves a point at the mean depth by.
  [[nodiscard]] double step_size(const Vector8d& step) const {
    const double f = std::abs(current_.camera.fx);
    return f * std::max(step.head<3>().norm() / mean_depth_, step.segment<3>(3).norm());
  }

  [[nodiscard]] const std::vector<float>& last_residuals() const { return residuals_; }

 private:
  void add_brightness_prior(const Alignment& alignment, System& system) const {
    const double rigid = options_.brightness ? 1.0 : 1e12;
    const double gain_weight = rigid / (kGainSigma * kGainSigma);
    const double bias_weight = rigid * kIntensityUnit * kIntensityUnit / (kBiasSigma * kBiasSigma);
    const double gain_error = alignment.gain - 1, bias_error = alignment.bias / kIntensityUnit;
    system.hessian(6, 6) += gain_weight;
    system.hessian(7, 7) += bias_weight;
    system.gradient[6] += gain_weight * gain_error;
    system.gradient[7] += bias_weight * bias_error;
    system.cost +=
        0.5 * (gain_weight * gain_error * gain_error + bias_weight * bias_error * bias_error);
  }

  // Residuals n . (ref_from_cur x_cur) - 1, x_cur the point that the sensor saw where the reference
  // point projects to: a share of depth, so its sigma is that of inverse depth times depth.
  void add_surface(const SE3& cur_from_ref, System& system) const {
    const Eigen::Matrix3f R = cur_from_ref.rotation.toRotationMatrix().cast<float>();
    const Eigen::Vector3f t = cur_from_ref.translation.cast<float>();
    const float fx = static_cast<float>(full_camera_.fx), fy = static_cast<float>(full_camera_.fy);
    const float cx = static_cast<float>(full_camera_.cx), cy = static_cast<float>(full_camera_.cy);
    const float noise = static_cast<float>(options_.depth_noise);
    const float weight = static_cast<float>(options_.geometric);
    Eigen::Matrix<float, 6, 6> hessian = Eigen::Matrix<float, 6, 6>::Zero();
    Eigen::Matrix<float, 6, 1> gradient = Eigen::Matrix<float, 6, 1>::Zero();
    double cost = 0;
    for (std::size_t i = 0; i < surface_.x.size(); ++i) {
      const Eigen::Vector3f p(surface_.x[i], surface_.y[i], surface_.z[i]);
      const Eigen::Vector3f q = R * p + t;
      const float u = fx * q.x() / q.z() + cx + 0.5F, v = fy * q.y() / q.z() + cy + 0.5F;
      const bool visible = q.z() > 0.05F && u >= 0 && v >= 0 &&
                           u < static_cast<float>(depth_.cols) &&
                           v < static_cast<float>(depth_.rows);
      const int column = visible ? static_cast<int>(u) : 0, row = visible ? static_cast<int>(v) : 0;
      const float z = visible ? depth_(row, column) : kOutside;
      if (std::isnan(z)) {
        cost += static_cast<double>(weight * kSurfaceSaturation);
        continue;
      }
      const Eigen::Vector3f seen((static_cast<float>(column) - cx) / fx * z,
                                 (static_cast<float>(row) - cy) / fy * z, z);
      const Eigen::Vector3f x = R.transpose() * (seen - t);
      const Eigen::Vector3f n(surface_.nx[i], surface_.ny[i], surface_.nz[i]);
      const float sigma = noise * surface_.z[i];
      const RobustValue value = robust(Loss::kTukey, kSurfaceTukey, (n.dot(x) - 1.F) / sigma);
      cost += static_cast<double>(weight * value.cost);
      const float w = weight * value.weight / (sigma * sigma);
      Eigen::Matrix<float, 6, 1> J;  // of exp(-xi) x
      J << -n, -x.cross(n);
      hessian.noalias() += (w * J) * J.transpose();
      gradient.noalias() += (w * (n.dot(x) - 1.F)) * J;
    }
    system.hessian.topLeftCorner<6, 6>() += hessian.cast<double>();
    system.gradient.head<6>() += gradient.cast<double>();
    system.cost += cost;
  }

  const ReferenceLevel& reference_;
  const SurfacePoints& surface_;
  const Level& current_;
  const Camera& full_camera_;
  const cv::Mat_<float>& depth_;
  const TrackOptions& options_;
  float sigma_;              // [grey levels]
  double mean_depth_ = 1.5;  // [m]
  mutable std::vector<float> residuals_;
};

float residual_sigma(const std::vector<float>& all, const TrackOptions& options) {
  std::vector<float> seen;
  seen.reserve(all.size());
  for (const float r : all)
    if (!std::isnan(r)) seen.push_back(r);
  return std::max(static_cast<float>(options.min_sigma), mad_sigma(seen));
}

// Pearson correlation of the reference's and the current intensities of the points in view: an
// image that shows something else, or nothing, fits only with gain zero, which residuals do not
// tell.
double correlation(const ReferenceLevel& reference, const Alignment& alignment,
                   const std::vector<float>& residuals) {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (std::isnan(residuals[i])) continue;
    const double before = static_cast<double>(reference.intensity[i]);
    const double now = static_cast<double>(residuals[i]) + alignment.gain * before + alignment.bias;
    n += 1;
    a += before;
    b += now;
    aa += before * before;
    bb += now * now;
    ab += before * now;
  }
  const double spread = (n * aa - a * a) * (n * bb - b * b);
  return spread > 0 ? (n * ab - a * b) / std::sqrt(spread) : 0.0;
}

}  // namespace

double coarse_cost(const Reference& reference, const Frame& frame, const Alignment& guess,
                   const TrackOptions& options) {
  const std::size_t l = std::min<std::size_t>(static_cast<std::size_t>(options.coarsest_level),
                                              frame.levels.size() - 1);
  const LevelProblem problem(reference, frame, l, options, 10.F);
  return problem.linearize(guess).cost;
}

TrackResult track(const Reference& reference, const Frame& frame, const Alignment& guess,
                  const TrackOptions& options) {
  TrackResult result{.alignment = guess};
  std::vector<float> all;
  const int coarsest = std::min(options.coarsest_level, static_cast<int>(frame.levels.size()) - 1);
  for (int l = coarsest; l >= std::min(options.finest_level, coarsest); --l) {
    const ReferenceLevel& points = reference.levels[static_cast<std::size_t>(l)];
    const Level& level = frame.levels[static_cast<std::size_t>(l)];
    residuals(points, level, result.alignment, all);
    const float sigma = residual_sigma(all, options);
    const LevelProblem problem(reference, frame, static_cast<std::size_t>(l), options, sigma);
    const MinimizeSummary summary = minimize(
        problem, result.alignment,
        {.max_iterations = options.max_iterations, .step_tolerance = options.step_tolerance});
    result.levels.push_back(
        {.level = l,
         .iterations = summary.iterations,
         .points = static_cast<int>(points.x.size()),
         .cost = summary.cost / std::max<double>(1.0, static_cast<double>(points.x.size())),
         .converged = summary.converged});
    if (l > std::min(options.finest_level, coarsest)) continue;

    residuals(points, level, result.alignment, all);
    result.sigma = residual_sigma(all, options);
    result.correlation = correlation(points, result.alignment, all);
    int seen = 0, fitting = 0;
    for (const float r : all) {
      seen += std::isnan(r) ? 0 : 1;
      fitting += std::abs(r) < kInlierSigmas * std::max(8.F, sigma) ? 1 : 0;
    }
    const double n = std::max<double>(1.0, static_cast<double>(all.size()));
    result.overlap = seen / n;
    result.inlier_ratio = fitting / std::max(1.0, static_cast<double>(seen));
    const LevelProblem last(reference, frame, static_cast<std::size_t>(l), options,
                            static_cast<float>(result.sigma));
    // Gain and bias are estimated too: what is known of the pose alone is the Schur complement.
    const System system = last.linearize(result.alignment);
    const Eigen::Matrix2d affine = system.hessian.bottomRightCorner<2, 2>();
    const Eigen::Matrix<double, 6, 2> cross = system.hessian.topRightCorner<6, 2>();
    result.information =
        (system.hessian.topLeftCorner<6, 6>() - cross * affine.inverse() * cross.transpose()) /
        kSharedError;
  }
  const bool fits = result.overlap >= options.min_overlap &&
                    result.inlier_ratio >= options.min_inliers &&
                    result.correlation >= options.min_correlation &&
                    is_finite(result.alignment.cur_from_ref) && result.information.allFinite();
  result.status = fits ? TrackStatus::kTracked : TrackStatus::kLost;
  return result;
}

}  // namespace edvo
