// SPDX-License-Identifier: MIT
// Structured light: the first Kinect, and the model of it in the ICL-NUIM sequences.
#include "edvo/synth/depth_models.hpp"
#include "edvo/synth/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace edvo::synth {
namespace {

constexpr double kBaseline = 0.075;                    // of projector and infrared camera [m]
constexpr double kDisparityScale = 580.0 * kBaseline;  // disparity = scale / depth [px m]

// Depth as measured: disparity with noise, then rounded to steps. Together they make sigma_z =
// depth_noise z^2 (d disparity = scale / z^2 dz; rounding has the variance step^2 / 12).
struct DisparityNoise {
  double sigma = 0, step = 0;  // [px]

  explicit DisparityNoise(const SensorOptions& options)
      : sigma(std::sqrt(std::max(0.0, std::pow(options.depth_noise * kDisparityScale, 2) -
                                          options.disparity_step * options.disparity_step / 12))),
        step(options.disparity_step) {}

  [[nodiscard]] float operator()(float depth, float unit_noise) const {
    double disparity = kDisparityScale / depth + sigma * unit_noise;
    if (step > 0) disparity = step * std::round(disparity / step);
    return disparity > 0 ? static_cast<float>(kDisparityScale / disparity) : kNoDepth;
  }
};

// Zero where the sensor says nothing: at grazing angles, and at part of the depth edges.
cv::Mat_<float> with_dropouts(const Render& exact, const Shot& shot) {
  constexpr float kJump = 0.05F;         // of the depth
  constexpr double kEdgeDropout = 0.15;  // share of the pixels beside a jump
  const float incidence = least_incidence(shot.options);
  cv::Mat_<float> depth(exact.depth.size());
  for_each_block(depth.rows, shot.threads, [&](int y) {
    Random random = shot.row(kSpeckleStream, y);
    for (int x = 0; x < depth.cols; ++x) {
      const float z = exact.depth(y, x);
      const auto jumps_to = [&](int to_y, int to_x) {
        return std::abs(exact.depth(to_y, to_x) - z) > kJump * z;
      };
      const bool edge =
          jumps_to(y, std::max(x - 1, 0)) || jumps_to(y, std::min(x + 1, depth.cols - 1)) ||
          jumps_to(std::max(y - 1, 0), x) || jumps_to(std::min(y + 1, depth.rows - 1), x);
      const bool lost = random.uniform() < kEdgeDropout && edge;
      const bool none = lost || std::isnan(z) || exact.incidence(y, x) < incidence;
      depth(y, x) = none ? 0 : z;
    }
  });
  return depth;
}

float interpolated(const cv::Mat_<float>& image, float x, float y) {
  x = std::clamp(x, 0.0F, static_cast<float>(image.cols - 1));
  y = std::clamp(y, 0.0F, static_cast<float>(image.rows - 1));
  const int left = std::min(static_cast<int>(x), image.cols - 2);
  const int top = std::min(static_cast<int>(y), image.rows - 2);
  const float a = x - static_cast<float>(left), b = y - static_cast<float>(top);
  return (1 - b) * ((1 - a) * image(top, left) + a * image(top, left + 1)) +
         b * ((1 - a) * image(top + 1, left) + a * image(top + 1, left + 1));
}

}  // namespace

cv::Mat_<float> kinect1_depth(const Render& exact, const Shot& shot) {
  const SensorOptions& options = shot.options;
  cv::Mat_<float> visible = exact.depth.clone();
  drop_shadows(exact.depth, visible, shot, kBaseline);
  cv::Mat_<float> shared;  // empty: each pixel has noise of its own
  if (options.depth_correlation > 0)
    shared = shared_noise(visible.size(), shot, options.depth_correlation);
  const DisparityNoise measure(options);
  const float incidence = least_incidence(options);
  const auto jitter = static_cast<float>(options.depth_edge_jitter);
  cv::Mat_<float> depth(visible.size(), kNoDepth);
  for_each_block(depth.rows, shot.threads, [&](int y) {
    Random random = shot.row(kJitterStream, y), own = shot.row(kDepthStream, y);
    const auto shifted = [&](int at, int end) {
      const float off = jitter * random.normal();
      return std::clamp(static_cast<int>(std::lround(static_cast<float>(at) + off)), 0, end - 1);
    };
    for (int x = 0; x < depth.cols; ++x) {
      const int from_x = jitter > 0 ? shifted(x, depth.cols) : x;
      const int from_y = jitter > 0 ? shifted(y, depth.rows) : y;
      const float noise = shared.empty() ? own.normal() : shared(y, x);
      const float z = visible(from_y, from_x);
      if (std::isnan(z) || exact.incidence(from_y, from_x) < incidence) continue;
      depth(y, x) = measure(z, noise);
    }
  });
  return depth;
}

cv::Mat_<float> icl_depth(const Render& exact, const Shot& shot) {
  constexpr float kShift = 0.5F;              // sigma [px]
  constexpr double kStepsPerInverse = 351.3;  // depth = this / (number of steps) [m]
  constexpr double kSigma = 1.0 / 6;          // [steps]
  const cv::Mat_<float> known = with_dropouts(exact, shot);
  cv::Mat_<float> depth(known.size(), kNoDepth);
  for_each_block(depth.rows, shot.threads, [&](int y) {
    Random jitter = shot.row(kJitterStream, y), noise = shot.row(kDepthStream, y);
    for (int x = 0; x < depth.cols; ++x) {
      const float from_x = static_cast<float>(x) + kShift * jitter.normal();
      const float from_y = static_cast<float>(y) + kShift * jitter.normal();
      const double unit = noise.normal();
      const float z = interpolated(known, from_x, from_y);
      if (z <= 0) continue;
      const double steps = std::round(kStepsPerInverse / z + kSigma * unit);
      if (steps >= 1) depth(y, x) = static_cast<float>(kStepsPerInverse / steps);
    }
  });
  return depth;
}

}  // namespace edvo::synth
