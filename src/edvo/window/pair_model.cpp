// SPDX-License-Identifier: MIT
#include "edvo/window/pair_model.hpp"

#include "edvo/align/bilinear.hpp"
#include "edvo/align/robust.hpp"
#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace edvo {
namespace {

using simd::Float8;

constexpr int kN = kKeyframeUnknowns;
// [grey levels] A pair that is given a larger sigma has its depth count less, too.
constexpr float kFittingSigma = 6.F;

// How far a motion between two keyframes moves points in the image, about [px].
double pixels_moved(const SE3& motion, const WindowKeyframe& host, const PairConstants& c) {
  double sum = 0;
  for (const WindowPoint& point : host.points) sum += point.inverse_depth;
  const double mean = sum / static_cast<double>(host.points.size());
  return static_cast<double>(c.camera.fx) *
         std::max(rotation_angle(motion), mean * motion.translation.norm());
}

struct Projection {
  float u, v;       // [px]
  float inverse_z;  // [1 / m]
};

// Where a target has a host's point; nothing where it is not in view.
std::optional<Projection> project_point(const PairConstants& c, const PairGeometry& g,
                                        const WindowPoint& point) {
  const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> R(
      g.target_from_host.r.data());
  const Eigen::Map<const Eigen::Vector3f> t(g.target_from_host.t.data());
  const auto& [fx, fy, cx, cy] = c.camera;
  const auto rho = static_cast<float>(point.inverse_depth);
  Eigen::Vector3f ray((point.u - cx) / fx, (point.v - cy) / fy, 1);
  move_to_middle_row(g.host_rows, point.v, ray.x(), ray.y(), ray.z(), rho);
  Eigen::Vector3f q = R * ray + rho * t;
  move_from_middle_row(g.target_rows, fy * q.y() / q.z() + cy, q.x(), q.y(), q.z(), rho);
  const Projection seen{fx * q.x() / q.z() + cx, fy * q.y() / q.z() + cy, rho / q.z()};
  const bool visible = q.z() > kLeastScale && seen.u >= kMargin && seen.v >= kMargin &&
                       seen.u < c.limit_u && seen.v < c.limit_v;
  return visible ? std::optional(seen) : std::nullopt;
}

// Sigma of the photometric residuals, by some points' own pixels [grey levels].
float shown_sigma(const PairConstants& c, const PairGeometry& g,
                  const std::vector<WindowPoint>& points, const WindowKeyframe& target) {
  constexpr std::size_t kEvery = 2;  // points: enough for a median
  std::vector<float> residuals;
  residuals.reserve(points.size() / kEvery + 1);
  for (std::size_t i = 0; i < points.size(); i += kEvery)
    if (const std::optional<Projection> seen = project_point(c, g, points[i]))
      residuals.push_back(bilinear(target.gray, seen->u, seen->v) -
                          g.gain * (points[i].intensity[0] - g.bias_host) - g.bias_target);
  return mad_sigma(residuals);
}

// Two keyframes that fit badly, since one is blurred, say less of where they are: with their
// images, and with their depth, which was taken in the same motion.
PairConstants weighed(PairConstants c, float shown) {
  const float own = c.pair_sigma_scale * shown;
  const float ratio = kFittingSigma / std::max(kFittingSigma, own);
  c.sigma = std::max(c.sigma, own);
  c.depth_weight *= ratio * ratio;
  return c;
}

void linearize_pair(const PairConstants& c, const WindowKeyframe& host,
                    const WindowKeyframe& target, const SE3& target_from_host, PairModel& model) {
  const bool first = model.depths.empty();
  model.host = host.stamp;
  model.target = target.stamp;
  model.linearized_at = model.target_from_host = target_from_host;
  model.geometry = pair_geometry(host, target);
  model.gain = target.gain / host.gain;
  model.offset = target.bias - model.gain * host.bias;
  model.depths.clear();
  for (const WindowPoint& point : host.points)
    model.depths.push_back(static_cast<float>(point.inverse_depth));
  model.sums = {};
  model.point_normals.assign(host.points.size(), {});
  model.coupling.resize(host.points.size() * kN);
  if (first) model.sigma = shown_sigma(c, model.geometry, host.points, target);
  model.cost = add_pair(weighed(c, model.sigma), model.geometry, host.points, target, model.sums,
                        model.point_normals.data(), model.coupling.data());
}

// What moves with the inverse depths: the points' own systems, by a step of the pair's unknowns,
// too; returns the change of the cost. pull: what the inverse depths add to the pair's gradient.
EDVO_CLONES float move_points(const std::vector<WindowPoint>& points, const float* step,
                              const float* coupling, float* depths, PointNormals* systems,
                              float* pull) {
  float cost = 0;
  Float8 sum{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto now = static_cast<float>(points[i].inverse_depth);
    const float moved = now - depths[i];
    depths[i] = now;
    const Float8 c = simd::Load(coupling + i * kN).value;
    const float by_pair = simd::sum(c * simd::Load(step).value);
    sum += moved * c;
    cost += moved * (systems[i].gradient + by_pair + 0.5F * systems[i].curvature * moved);
    systems[i].gradient += by_pair + systems[i].curvature * moved;
  }
  simd::store(pull, sum);
  return cost;
}

// The same second-order cost about the present state.
void move_pair(const WindowKeyframe& host, const WindowKeyframe& target,
               const SE3& target_from_host, PairModel& model) {
  const double gain = target.gain / host.gain, offset = target.bias - gain * host.bias;
  Eigen::Matrix<double, kN, 1> wide;
  wide.head<6>() = log(target_from_host * inverse(model.target_from_host));
  // By the brightness as it was where linearized: radiance is (I_host - bias) / gain of the host.
  wide[6] = (gain - model.gain) / static_cast<double>(model.geometry.inverse_host_gain);
  wide[7] = (offset - model.offset +
             static_cast<double>(model.geometry.bias_host) * (gain - model.gain)) /
            kBrightnessUnit;
  model.target_from_host = target_from_host;
  model.gain = gain;
  model.offset = offset;
  const Eigen::Matrix<float, kN, 1> step = wide.cast<float>();
  Eigen::Matrix<float, kN, 1> pull;
  const float by_points = move_points(host.points, step.data(), model.coupling.data(),
                                      model.depths.data(), model.point_normals.data(), pull.data());
  const Eigen::Map<const Eigen::Matrix<float, kN, kN, Eigen::RowMajor>> H(
      model.sums.hessian.data());
  Eigen::Map<Eigen::Matrix<float, kN, 1>> gradient(model.sums.gradient.data());
  const Eigen::Matrix<float, kN, 1> bend = H * step;
  model.cost += static_cast<double>(by_points + step.dot(gradient + 0.5F * bend));
  gradient += bend + pull;
}

}  // namespace

void update_pair(const PairConstants& c, const WindowKeyframe& host, const WindowKeyframe& target,
                 double limit, PairModel& model) {
  const SE3 now = inverse(target.world_from_key) * host.world_from_key;
  const bool known = !model.depths.empty();
  if (known && pixels_moved(now * inverse(model.linearized_at), host, c) < limit)
    move_pair(host, target, now, model);
  else
    linearize_pair(c, host, target, now, model);
}

void append_depth_errors(const PairConstants& c, const PairGeometry& g,
                         const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                         std::vector<float>& errors) {
  constexpr std::size_t kEvery = 4;  // points: enough for a median
  for (std::size_t i = 0; i < points.size(); i += kEvery) {
    const std::optional<Projection> at = project_point(c, g, points[i]);
    if (!at) continue;
    const float seen = inverse_depth_at(target, at->u, at->v);
    const float bias = c.depth_bias * seen;
    errors.push_back((at->inverse_z - seen) / std::sqrt(c.depth_variance + bias * bias));
  }
}

}  // namespace edvo
