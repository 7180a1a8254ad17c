// SPDX-License-Identifier: MIT
#include "edvo/align/align.hpp"

#include "edvo/align/levenberg_marquardt.hpp"
#include "edvo/align/warp.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace edvo {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;

constexpr double kRigid = 1e12;      // a brightness prior that holds
constexpr double kOnlyAStart = 3.0;  // times the tolerance of steps at all but the finest level
constexpr float kLeastSpread = 8.F;  // [grey levels] sigma of residuals that fit is never less
constexpr double kFlat = 0.1;        // [grey levels] an image of a smaller spread shows nothing
constexpr float kLeastDepthNoise = 0.03F;  // of the depth noise expected
// Neighbours share the errors of depth and of interpolation. How much is seen in the gradients of
// bands of the image, of which the pose makes the sum zero (a cluster-robust covariance: Liang,
// Zeger 1986); what whole bands share is not, so there is a factor. Measured on the sensors of
// benchmarks/sensors.toml (docs/evaluation.md).
constexpr std::size_t kBands = 16;
constexpr double kSharedByBands = 15.0;
constexpr double kLeastScatter = 0.5;  // noise does not tell of smooth errors of depth
// Weight of the position prior. The sums take residuals as independent, of which about ten tell as
// much as one: the prior is multiplied by ten as well, and doubled. Four times instead of twice
// turns the camera where it moves aside, if only the middle of the image has depth
// (docs/experiments/0010-few-points.md).
constexpr double kPriorWeight = 20.0;

// xi, gain, bias / kBrightnessUnit.
using System = LinearSystem<8>;

bool same(const Alignment& a, const Alignment& b) {
  return a.cur_from_ref.rotation.coeffs() == b.cur_from_ref.rotation.coeffs() &&
         a.cur_from_ref.translation == b.cur_from_ref.translation && a.gain == b.gain &&
         a.bias == b.bias;
}

// One pyramid level as a least-squares problem with a fixed scale of the residuals.
class LevelProblem {
 public:
  LevelProblem(const Reference& reference, const Frame& frame, std::size_t level,
               const AlignOptions& options, AlignScratch& scratch, const PositionPrior& prior)
      : reference_(reference.levels[level]),
        surface_(reference.surface),
        current_(frame.levels[level]),
        full_camera_(frame.levels.front().camera),
        depth_(frame.depth),
        readout_(frame.shutter.readout()),
        options_(options),
        scratch_(scratch),
        prior_(prior),
        depth_noise_(static_cast<float>(options.depth_noise)) {}

  // NaN where a point is not in view. Computed once for an alignment that is asked for again.
  [[nodiscard]] const std::vector<float>& residuals(const Alignment& alignment) const {
    if (!residuals_at_ || !same(alignment, *residuals_at_)) {
      photometric_residuals(reference_, current_, readout_, alignment, scratch_.residuals);
      residuals_at_ = alignment;
    }
    return scratch_.residuals;
  }

  void set_sigma(float sigma) { sigma_ = sigma; }  // [grey levels]

  // The sensor may be better than we think, or exact; alignment that is still off makes its
  // residuals large, and then what we think of it holds.
  void set_depth_noise(const SE3& cur_from_ref) {
    const auto most = static_cast<float>(options_.depth_noise);
    depth_noise_ = std::clamp(
        surface_sigma(surface_, associations(cur_from_ref), cur_from_ref, scratch_.surface_errors),
        kLeastDepthNoise * most, most);
  }

  [[nodiscard]] System linearize(const Alignment& alignment) const {
    return assemble(alignment, photometric(alignment, all_of(residuals(alignment))),
                    depth(alignment.cur_from_ref, all_of(surface_.x)));
  }

  // The inverse covariance of the pose alone: gain and bias are estimated too, so it is the Schur
  // complement, divided by how much more bands of the image scatter than independent residuals.
  [[nodiscard]] Matrix6d information(const Alignment& alignment) const {
    const std::size_t points = residuals(alignment).size();
    PhotometricSums images;
    PoseSums depths;
    std::array<Vector8d, kBands> image_gradients;
    std::array<Vector6d, kBands> depth_gradients;
    for (std::size_t band = 0; band < kBands; ++band) {
      const PhotometricSums image = photometric(alignment, part_of(points, band, kBands));
      const PoseSums surface =
          depth(alignment.cur_from_ref, part_of(surface_.x.size(), band, kBands));
      image_gradients[band] = image.gradient;
      depth_gradients[band] = surface.gradient;
      images += image;
      depths += surface;
    }
    const System system = assemble(alignment, images, depths);
    const Eigen::Matrix<double, 6, 2> cross = system.hessian.topRightCorner<6, 2>();
    const Eigen::Matrix<double, 6, 2> slope =
        cross * system.hessian.bottomRightCorner<2, 2>().inverse();
    const Matrix6d schur = system.hessian.topLeftCorner<6, 6>() - slope * cross.transpose();
    const Eigen::LDLT<Matrix6d> decomposition(schur);
    double squares = 0;
    for (std::size_t band = 0; band < kBands; ++band)
      for (const Vector6d& gradient :
           {Vector6d(image_gradients[band].head<6>() - slope * image_gradients[band].tail<2>()),
            depth_gradients[band]})
        squares += gradient.dot(decomposition.solve(gradient));
    return schur / (kSharedByBands * std::max(kLeastScatter, squares / 6));
  }

  [[nodiscard]] double cost(const Alignment& alignment) const {
    System system;
    system.cost = photometric_cost(reference_, residuals(alignment), sigma_, options_.loss,
                                   static_cast<float>(options_.loss_parameter));
    add_all_others(alignment, depth(alignment.cur_from_ref, all_of(surface_.x)), system);
    return system.cost;
  }

  [[nodiscard]] static Alignment update(const Alignment& alignment, const Vector8d& step) {
    return {.cur_from_ref = alignment.cur_from_ref * exp(step.head<6>()),
            .gain = alignment.gain + step[6],
            .bias = alignment.bias + kBrightnessUnit * step[7]};
  }

  // Pixels that a step moves points by.
  [[nodiscard]] double step_size(const Vector8d& step) const {
    return pixels_moved(current_.camera, step.head<3>().norm(), step.segment<3>(3).norm());
  }

 private:
  [[nodiscard]] PhotometricSums photometric(const Alignment& alignment, PointRange range) const {
    return sum_photometric(reference_, residuals(alignment), range, alignment.gain, sigma_,
                           options_.loss, static_cast<float>(options_.loss_parameter));
  }

  // Nothing if depth has no weight.
  [[nodiscard]] PoseSums depth(const SE3& cur_from_ref, PointRange range) const {
    if (options_.depth_weight <= 0) return {};
    return sum_surface(surface_, associations(cur_from_ref), range, cur_from_ref, depth_noise_,
                       static_cast<float>(options_.depth_weight));
  }

  [[nodiscard]] const DepthAssociations& associations(const SE3& cur_from_ref) const {
    if (scratch_.associations.is_stale(cur_from_ref, full_camera_))
      associate_depth(surface_, full_camera_, depth_, cur_from_ref, scratch_.associations);
    return scratch_.associations;
  }

  [[nodiscard]] System assemble(const Alignment& alignment, const PhotometricSums& images,
                                const PoseSums& depths) const {
    System system;
    system.hessian = images.hessian;
    system.gradient = images.gradient;
    system.cost = images.cost;
    add_all_others(alignment, depths, system);
    system.hessian = system.hessian.selfadjointView<Eigen::Upper>();
    return system;
  }

  // What is not photometric. Of the Hessian the upper triangle.
  void add_all_others(const Alignment& alignment, const PoseSums& depths, System& system) const {
    system.hessian.topLeftCorner<6, 6>() += depths.hessian;
    system.gradient.head<6>() += depths.gradient;
    system.cost += depths.cost;
    brightness_prior(alignment.gain, alignment.bias, options_.brightness ? 1 : kRigid)
        .add_to(system, 6);
    if (prior_.sigma > 0) add_position_prior(alignment.cur_from_ref, system);
  }

  // The centre is c = -R' t; a step moves it by d c = -rho + c x phi.
  void add_position_prior(const SE3& cur_from_ref, System& system) const {
    const Eigen::Vector3d c = inverse(cur_from_ref).translation;
    Eigen::Matrix<double, 3, 6> J;
    J << -1, 0, 0, 0, -c.z(), c.y(),  //
        0, -1, 0, c.z(), 0, -c.x(),   //
        0, 0, -1, -c.y(), c.x(), 0;
    const Eigen::Vector3d error = c - prior_.centre;
    const double weight = kPriorWeight / (prior_.sigma * prior_.sigma);
    system.hessian.topLeftCorner<6, 6>() += weight * J.transpose() * J;
    system.gradient.head<6>() += weight * J.transpose() * error;
    system.cost += 0.5 * weight * error.squaredNorm();
  }

  const ReferenceLevel& reference_;
  const SurfacePoints& surface_;
  const Level& current_;
  const Camera& full_camera_;
  const Depth& depth_;
  Vector6d readout_;
  const AlignOptions& options_;
  AlignScratch& scratch_;
  PositionPrior prior_;
  float sigma_ = 10.F;                             // [grey levels]
  float depth_noise_ = 0.F;                        // [1 / m]
  mutable std::optional<Alignment> residuals_at_;  // of which those in scratch_ are
};

float residual_sigma(const std::vector<float>& residuals, const AlignOptions& options) {
  return std::max(static_cast<float>(options.min_sigma), mad_sigma(residuals));
}

// Pearson correlation of the reference's and the current intensities of the points whose residuals
// are below a limit [grey levels]: an image that shows something else, or nothing, fits only with
// gain zero, which residuals do not tell. Points hidden by something in front say nothing.
double correlation(const ReferenceLevel& reference, const Alignment& alignment,
                   const std::vector<float>& residuals, float limit) {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    if (!(std::abs(residuals[i]) < limit)) continue;
    const double before = static_cast<double>(reference.intensity[i]);
    const double now = static_cast<double>(residuals[i]) + alignment.gain * before + alignment.bias;
    n += 1;
    a += before;
    b += now;
    aa += before * before;
    bb += now * now;
    ab += before * now;
  }
  const double spread_before = n * aa - a * a, spread_now = n * bb - b * b;
  const double flat = n * n * kFlat * kFlat;  // below, all is rounding
  if (!(spread_before > flat && spread_now > flat)) return 0.0;
  return (n * ab - a * b) / std::sqrt(spread_before * spread_now);
}

}  // namespace

double coarse_cost(const Reference& reference, const Frame& frame, const Alignment& guess,
                   const AlignOptions& options, AlignScratch& scratch) {
  const std::size_t l = std::min<std::size_t>(static_cast<std::size_t>(options.coarsest_level),
                                              frame.levels.size() - 1);
  scratch.associations.from.reset();
  const LevelProblem problem(reference, frame, l, options, scratch, {});
  return problem.cost(guess);
}

double mean_flow(const Reference& reference, int level, const SE3& a, const SE3& b) {
  constexpr std::size_t kEvery = 8;  // points: a mean needs no more
  const ReferenceLevel& points = reference.levels[static_cast<std::size_t>(level)];
  const auto project = [&](const Eigen::Vector3d& p) -> Eigen::Vector2d {
    const double z = std::max<double>(kNearest, p.z());
    return {points.camera.fx * p.x() / z, points.camera.fy * p.y() / z};
  };
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < points.count; i += kEvery, ++n) {
    const Eigen::Vector3d p = Eigen::Vector3f(points.x[i], points.y[i], points.z[i]).cast<double>();
    sum += std::min<double>(points.camera.width, (project(a * p) - project(b * p)).norm());
  }
  return sum / std::max(1, n) / points.camera.width;
}

AlignResult align(const Reference& reference, const Frame& frame, const Alignment& guess,
                  const AlignOptions& options, AlignScratch& scratch, const PositionPrior& prior) {
  AlignResult result{.alignment = guess};
  scratch.associations.from.reset();  // what was seen of another frame
  const int coarsest = std::min(options.coarsest_level, static_cast<int>(frame.levels.size()) - 1);
  const int finest = std::min(options.finest_level, coarsest);
  for (int l = coarsest; l >= finest; --l) {
    const ReferenceLevel& points = reference.levels[static_cast<std::size_t>(l)];
    LevelProblem problem(reference, frame, static_cast<std::size_t>(l), options, scratch, prior);
    const float sigma = residual_sigma(problem.residuals(result.alignment), options);
    problem.set_sigma(sigma);
    if (options.depth_weight > 0) problem.set_depth_noise(result.alignment.cur_from_ref);
    const MinimizeSummary summary =
        minimize(problem, result.alignment,
                 {.max_iterations = options.max_iterations,
                  .step_tolerance = (l > finest ? kOnlyAStart : 1.0) * options.step_tolerance});
    result.levels.push_back(
        {.level = l,
         .iterations = summary.iterations,
         .points = static_cast<int>(points.count),
         .cost = summary.cost / std::max<double>(1.0, static_cast<double>(points.count)),
         .converged = summary.converged});
    if (l > finest) continue;

    const std::vector<float>& all = problem.residuals(result.alignment);
    const float spread = residual_sigma(all, options);
    result.sigma = spread;
    result.correlation =
        correlation(points, result.alignment, all, kInlierSigmas * std::max(kLeastSpread, spread));
    int seen = 0, fitting = 0;
    for (const float r : all) {
      seen += std::isnan(r) ? 0 : 1;
      fitting += std::abs(r) < kInlierSigmas * std::max(kLeastSpread, sigma) ? 1 : 0;
    }
    const double n = std::max<double>(1.0, static_cast<double>(points.count));
    result.overlap = seen / n;
    result.inlier_ratio = fitting / std::max(1.0, static_cast<double>(seen));
    problem.set_sigma(static_cast<float>(result.sigma));
    result.information = problem.information(result.alignment);
  }
  const bool fits = result.overlap >= options.min_overlap &&
                    result.inlier_ratio >= options.min_inliers &&
                    result.correlation >= options.min_correlation &&
                    is_finite(result.alignment.cur_from_ref) && result.information.allFinite();
  result.status = fits ? AlignStatus::kTracked : AlignStatus::kLost;
  return result;
}

AlignResult align(const Reference& reference, const Frame& frame, const Alignment& guess,
                  const AlignOptions& options) {
  AlignScratch scratch;
  return align(reference, frame, guess, options, scratch);
}

}  // namespace edvo
