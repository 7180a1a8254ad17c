// SPDX-License-Identifier: MIT
#include "edvo/track/window_pair.hpp"

#include "edvo/core/lanes.hpp"
#include "edvo/core/simd.hpp"
#include "edvo/track/bilinear.hpp"
#include "edvo/track/robust.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr float kLeastScale = 0.05F;  // of a point's depth in the target by that in the host
constexpr float kMargin = 3.F;        // [px] room that a patch needs
constexpr float kSaturation = 6.F;    // [sigmas] what a patch out of view or not matching pays
constexpr float kOccluded = 1.10F;    // seen depth nearer by this factor: something stands in front
constexpr float kDepthHuber = 2.F;    // [sigmas]
constexpr std::size_t kAhead = 4;     // points that memory is asked for before their turn

static_assert(kPatchSize == kLanes && kKeyframeUnknowns == kLanes);

// Sums over a patch that all of its second derivatives are made of: the geometry is that of the
// patch's centre, as in DSO, the residuals and gradients are each pixel's own.
enum Sum { kXX, kXY, kYY, kXA, kYA, kX, kY, kAA, kA, kOne, kXR, kYR, kAR, kR, kCost, kSums };

// An image at the pixels of a patch.
struct Samples {
  Floats value, gx, gy;  // [grey levels], [grey levels / px]
};

// Byte k of each number.
template <int k>
[[gnu::always_inline]] inline void byte_of(const Ints& word, Floats& out) {
  out = __builtin_convertvector((word >> (8 * k)) & 255, Floats);
}

// Bilinear, the gradient by central differences of the same interpolant. (u, v): two pixels of room
// at least. Four neighbours in a row are read at once, the left one in the low byte.
[[gnu::always_inline]] inline void sample(const cv::Mat_<std::uint8_t>& gray, const Floats& u,
                                          const Floats& v, Samples& out) {
  const Ints column = __builtin_convertvector(u, Ints);
  const Ints row = __builtin_convertvector(v, Ints);
  const Floats a = u - __builtin_convertvector(column, Floats);
  const Floats b = v - __builtin_convertvector(row, Floats);
  const auto stride = static_cast<std::int32_t>(gray.step[0]);
  const Ints offset = (row - 1) * stride + column - 1;
  const std::uint8_t* pixels = gray.data;
  Ints rows[4];
  for (int r = 0; r < 4; ++r) {
    Ints words{};
    for (std::size_t k = 0; k < kLanes; ++k) {
      std::int32_t word = 0;
      std::memcpy(&word, pixels + offset[k] + r * stride, sizeof word);
      words[k] = word;
    }
    rows[r] = words;
  }
  Floats at[4], left[2], right[2];  // interpolated along the rows at u, u - 1 and u + 1
  for (int r = 0; r < 4; ++r) {
    Floats p0, p1, p2, p3;
    byte_of<1>(rows[r], p1);
    byte_of<2>(rows[r], p2);
    at[r] = p1 + a * (p2 - p1);
    if (r != 1 && r != 2) continue;
    byte_of<0>(rows[r], p0);
    byte_of<3>(rows[r], p3);
    left[r - 1] = p0 + a * (p1 - p0);
    right[r - 1] = p2 + a * (p3 - p2);
  }
  out.value = at[1] + b * (at[2] - at[1]);
  const Floats upper = right[0] - left[0], lower = right[1] - left[1];
  out.gx = 0.5F * (upper + b * (lower - upper));
  const Floats first = at[2] - at[0], second = at[3] - at[1];
  out.gy = 0.5F * (first + b * (second - first));
}

// Asks the memory for what a point's patch will read, so that it is there when its turn comes: the
// images of a window are larger than the caches, and a patch is somewhere in them.
[[gnu::always_inline]] inline void fetch(const PairConstants& c, const PairGeometry& g,
                                         const WindowPoint& point, const WindowKeyframe& target) {
  const auto& R = g.rotation;
  const auto& t = g.translation;
  const float rho = static_cast<float>(point.inverse_depth);
  const float rx = (point.u - c.cx) / c.fx, ry = (point.v - c.cy) / c.fy;
  const float iz = 1.F / (R[6] * rx + R[7] * ry + R[8] + rho * t[2]);
  const float u = c.fx * (R[0] * rx + R[1] * ry + R[2] + rho * t[0]) * iz + c.cx;
  const float v = c.fy * (R[3] * rx + R[4] * ry + R[5] + rho * t[1]) * iz + c.cy;
  if (!(u >= kMargin && v >= kMargin && u < c.limit_u && v < c.limit_v)) return;
  const int column = static_cast<int>(u), row = static_cast<int>(v);
  __builtin_prefetch(target.inverse_depth[(row + 1) / 2] + (column + 1) / 2);
  for (int y = row - 3; y <= row + 4; ++y) __builtin_prefetch(target.gray[y] + column);
}

// Halves, quarters: sums of eight lanes on their way to one.
[[gnu::always_inline]] inline void sum_halves(const Floats& a, const Floats& b, Floats& sum) {
  sum = __builtin_shuffle(a, b, Ints{0, 1, 2, 3, 8, 9, 10, 11}) +
        __builtin_shuffle(a, b, Ints{4, 5, 6, 7, 12, 13, 14, 15});
}

[[gnu::always_inline]] inline void sum_quarters(const Floats& a, const Floats& b, Floats& sum) {
  sum = __builtin_shuffle(a, b, Ints{0, 1, 8, 9, 4, 5, 12, 13}) +
        __builtin_shuffle(a, b, Ints{2, 3, 10, 11, 6, 7, 14, 15});
}

// The sums over the lanes of eight numbers each.
[[gnu::always_inline]] inline void sum_lanes(const Floats* in, float* out) {
  Floats h[4], q[2];
  for (int i = 0; i < 4; ++i) sum_halves(in[i], in[i + 4], h[i]);
  sum_quarters(h[0], h[1], q[0]);
  sum_quarters(h[2], h[3], q[1]);
  lanes(out) = __builtin_shuffle(q[0], q[1], Ints{0, 2, 8, 10, 4, 6, 12, 14}) +
               __builtin_shuffle(q[0], q[1], Ints{1, 3, 9, 11, 5, 7, 13, 15});
}

}  // namespace

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

PairConstants pair_constants(const Camera& camera, const WindowOptions& options) {
  const float huber = static_cast<float>(options.huber);
  const double noise = options.depth_noise;
  return {.fx = static_cast<float>(camera.fx),
          .fy = static_cast<float>(camera.fy),
          .cx = static_cast<float>(camera.cx),
          .cy = static_cast<float>(camera.cy),
          .limit_u = static_cast<float>(camera.width) - 1 - kMargin,
          .limit_v = static_cast<float>(camera.height) - 1 - kMargin,
          .sigma = static_cast<float>(options.sigma),
          .own_sigma = static_cast<float>(options.own_sigma),
          .huber = huber,
          .most = huber * (kSaturation - 0.5F * huber) * kPatchSize,
          .geometric = static_cast<float>(options.geometric),
          .depth_variance = static_cast<float>(2 * noise * noise),
          .depth_bias = static_cast<float>(options.depth_bias)};
}

EDVO_CLONES double add_pair(const PairConstants& c, const PairGeometry& g,
                            const std::vector<WindowPoint>& points, const WindowKeyframe& target,
                            PairSums& pair, DepthSystem* depths, float* coupling) {
  const auto& R = g.rotation;
  const auto& t = g.translation;
  double total = 0;
  const float inverse_sigma = 1 / c.sigma;
  const Floats &pattern_x = lanes(kPatternX), &pattern_y = lanes(kPatternY);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const WindowPoint& point = points[i];
    if (i + kAhead < points.size()) fetch(c, g, points[i + kAhead], target);
    float* couple = coupling + i * kN;
    const float rho = static_cast<float>(point.inverse_depth);
    const float tx = rho * t[0], ty = rho * t[1], tz = rho * t[2];
    const Floats rx = (point.u + pattern_x - c.cx) / c.fx;
    const Floats ry = (point.v + pattern_y - c.cy) / c.fy;
    const Floats qz = R[6] * rx + R[7] * ry + (R[8] + tz);  // rho times the point in the target
    const Floats iz = 1.F / qz;
    const Floats x = (R[0] * rx + R[1] * ry + (R[2] + tx)) * iz;
    const Floats y = (R[3] * rx + R[4] * ry + (R[5] + ty)) * iz;
    const Floats u = c.fx * x + c.cx;
    const Floats v = c.fy * y + c.cy;
    const Ints fits =
        (qz > kLeastScale) & (u >= kMargin) & (v >= kMargin) & (u < c.limit_u) & (v < c.limit_v);
    std::int32_t visible = -1;
    for (int k = 0; k < kPatchSize; ++k) visible &= fits[k];
    lanes(couple) = Floats{};
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
    Samples image;
    sample(target.gray, u, v, image);
    const Floats radiance = lanes(point.intensity.data()) - g.bias_host;
    const Floats r = (image.value - g.gain * radiance - g.bias_target) * inverse_sigma;
    const Floats size = r < 0.F ? -r : r;
    const Floats inlier = size < c.huber ? size : Floats{} + c.huber;
    const Floats larger = size > c.huber ? size : Floats{} + c.huber;
    const Floats& softness = lanes(point.softness.data());
    const Floats w = softness * c.huber / larger;
    const Floats by_gain = -radiance * g.inverse_host_gain;
    const Floats wx = w * image.gx, wy = w * image.gy, wa = w * by_gain;
    const Floats patch[2 * kLanes] = {wx * image.gx,
                                      wx * image.gy,
                                      wy * image.gy,
                                      wx * by_gain,
                                      wy * by_gain,
                                      wx,
                                      wy,
                                      wa * by_gain,
                                      wa,
                                      w,
                                      wx * r,
                                      wy * r,
                                      wa * r,
                                      w * r,
                                      softness * inlier * (size - 0.5F * inlier),
                                      Floats{}};
    float sum[2 * kLanes];
    sum_lanes(patch, sum);
    sum_lanes(patch + kLanes, sum + kLanes);
    // Depth residual 1 / z - seen, where the target's depth is smooth.
    float cost = sum[kCost], depth_weight = 0;
    const float depth_error = inverse_z - seen;
    if (c.geometric > 0 && seen == seen) {
      const float bias = c.depth_bias * seen;
      const float variance = c.depth_variance + bias * bias;
      const float norm = std::abs(depth_error) / std::sqrt(variance);
      const float fitting = std::min(norm, kDepthHuber);
      cost += c.geometric * fitting * (norm - 0.5F * fitting);
      depth_weight = c.geometric / variance * kDepthHuber / std::max(norm, kDepthHuber);
    }
    if (!(cost <= c.most)) {
      total += static_cast<double>(c.most);
      continue;
    }
    total += static_cast<double>(cost);

    const float s = inverse_sigma, s2 = s * s;
    const float fx = c.fx, fy = c.fy, px = x[0], py = y[0];
    const float unit = -static_cast<float>(kBrightnessUnit);
    // d (u, v) / d xi at the centre; two zeros pad to the brightness columns.
    const Floats du = {
        fx * inverse_z, 0, -fx * px * inverse_z, -fx * px * py, fx * (1 + px * px), -fx * py, 0, 0};
    const Floats dv = {
        0, fy * inverse_z, -fy * py * inverse_z, -fy * (1 + py * py), fy * px * py, fy * px, 0, 0};
    // Gradient-weighted columns of the Jacobian.
    Floats gu = s2 * (sum[kXX] * du + sum[kXY] * dv);
    Floats gv = s2 * (sum[kXY] * du + sum[kYY] * dv);
    gu[6] = s2 * sum[kXA];
    gu[7] = s2 * unit * sum[kX];
    gv[6] = s2 * sum[kYA];
    gv[7] = s2 * unit * sum[kY];
    // d (u, v) / d rho = f (t - (x, y) t_z) / q_z
    const float ru = fx * (t[0] - px * t[2]) * iz[0], rv = fy * (t[1] - py * t[2]) * iz[0];
    float* const hessian = pair.hessian.data();
    for (int a = 0; a < 6; ++a) lanes(hessian + a * kN) += du[a] * gu + dv[a] * gv;
    lanes(hessian + 6 * kN) += du * gu[6] + dv * gv[6];
    lanes(hessian + 7 * kN) += du * gu[7] + dv * gv[7];
    pair.hessian[6 * kN + 6] += s2 * sum[kAA];
    pair.hessian[6 * kN + 7] += s2 * unit * sum[kA];
    pair.hessian[7 * kN + 6] += s2 * unit * sum[kA];
    pair.hessian[7 * kN + 7] += s2 * unit * unit * sum[kOne];
    lanes(pair.gradient.data()) += s * (sum[kXR] * du + sum[kYR] * dv);
    lanes(couple) = ru * gu + rv * gv;
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

namespace {

// How far a motion between two keyframes moves points in the image, about [px].
double pixels_moved(const SE3& motion, const WindowKeyframe& host, const PairConstants& c) {
  double sum = 0;
  for (const WindowPoint& point : host.points) sum += point.inverse_depth;
  const double mean = sum / static_cast<double>(host.points.size());
  return static_cast<double>(c.fx) *
         std::max(rotation_angle(motion), mean * motion.translation.norm());
}

struct Seen {
  float u, v;       // [px]
  float inverse_z;  // [1 / m]
};

// Where a target has a host's point; nothing where it is not in view.
std::optional<Seen> see(const PairConstants& c, const PairGeometry& g, const WindowPoint& point) {
  const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> R(g.rotation.data());
  const Eigen::Map<const Eigen::Vector3f> t(g.translation.data());
  const auto rho = static_cast<float>(point.inverse_depth);
  const Eigen::Vector3f ray((point.u - c.cx) / c.fx, (point.v - c.cy) / c.fy, 1);
  const Eigen::Vector3f q = R * ray + rho * t;
  const Seen seen{c.fx * q.x() / q.z() + c.cx, c.fy * q.y() / q.z() + c.cy, rho / q.z()};
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
    if (const std::optional<Seen> seen = see(c, g, points[i]))
      residuals.push_back(bilinear(target.gray, seen->u, seen->v) -
                          g.gain * (points[i].intensity[0] - g.bias_host) - g.bias_target);
  return mad_sigma(residuals);
}

// Two keyframes that fit badly, since one is blurred, say less of where they are: with their
// images, and with their depth, which was taken in the same motion.
PairConstants weighed(PairConstants c, float shown) {
  const float sigma = std::max(c.sigma, c.own_sigma * shown);
  const float ratio = c.sigma / sigma;
  c.geometric *= ratio * ratio;
  c.sigma = sigma;
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
  model.depth_systems.assign(host.points.size(), {});
  model.coupling.resize(host.points.size() * kN);
  if (first) model.sigma = shown_sigma(c, model.geometry, host.points, target);
  model.cost = add_pair(weighed(c, model.sigma), model.geometry, host.points, target, model.sums,
                        model.depth_systems.data(), model.coupling.data());
}

// What moves with the inverse depths: the points' own systems, by a step of the pair's unknowns,
// too; returns the change of the cost. pull: what the inverse depths add to the pair's gradient.
EDVO_CLONES float move_points(const std::vector<WindowPoint>& points, const float* step,
                              const float* coupling, float* depths, DepthSystem* systems,
                              float* pull) {
  float cost = 0;
  Floats sum{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto now = static_cast<float>(points[i].inverse_depth);
    const float moved = now - depths[i];
    depths[i] = now;
    const Floats& c = lanes(coupling + i * kN);
    const float by_pair = sum_of(c * lanes(step));
    sum += moved * c;
    cost += moved * (systems[i].gradient + by_pair + 0.5F * systems[i].curvature * moved);
    systems[i].gradient += by_pair + systems[i].curvature * moved;
  }
  lanes(pull) = sum;
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
                                      model.depths.data(), model.depth_systems.data(), pull.data());
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
    const std::optional<Seen> at = see(c, g, points[i]);
    if (!at) continue;
    const float seen = target.inverse_depth(static_cast<int>(0.5F * at->v + 0.5F),
                                            static_cast<int>(0.5F * at->u + 0.5F));
    const float bias = c.depth_bias * seen;
    errors.push_back((at->inverse_z - seen) / std::sqrt(c.depth_variance + bias * bias));
  }
}

}  // namespace edvo
