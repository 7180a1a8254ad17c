// SPDX-License-Identifier: MIT
#include "edvo/synth/sensor.hpp"

#include "edvo/synth/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace edvo::synth {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kBaseline = 0.075;                    // of projector and infrared camera [m]
constexpr double kDisparityScale = 580.0 * kBaseline;  // disparity = scale / depth [px m]
constexpr int kMissingBlock = 8;                       // [px]

// Independent streams of one frame.
enum Stream : std::uint64_t { kColourStream, kDepthStream, kJitterStream, kMissingStream };

// What every stage needs to know of a frame.
struct Shot {
  const SensorOptions& options;
  std::uint64_t seed = 0, frame = 0;
  int threads = 0;

  [[nodiscard]] Random row(Stream stream, int y) const {
    return Random{seed, frame, stream, static_cast<std::uint64_t>(y)};
  }
};

double exposure(const SensorOptions& options, double seconds) {
  const double roll = 1 + options.exposure_amplitude *
                              std::sin(2 * std::numbers::pi * seconds / options.exposure_period);
  return seconds < options.exposure_jump_time ? roll : roll * options.exposure_jump;
}

cv::Mat_<cv::Vec3b> colour(const cv::Mat_<cv::Vec3f>& exact, const Shot& shot, double seconds) {
  const SensorOptions& options = shot.options;
  const bool noise = options.noise;
  const auto gain = static_cast<float>(noise ? exposure(options, seconds) : 1);
  const auto sigma = static_cast<float>(noise ? options.colour_noise : 0);
  const auto vignetting = static_cast<float>(noise ? options.vignetting : 0);
  const float cx = 0.5F * static_cast<float>(exact.cols - 1);
  const float cy = 0.5F * static_cast<float>(exact.rows - 1);
  cv::Mat_<cv::Vec3b> image(exact.size());
  for_each_block(exact.rows, shot.threads, [&](int y) {
    Random random = shot.row(kColourStream, y);
    const float dy = static_cast<float>(y) - cy;
    for (int x = 0; x < exact.cols; ++x) {
      const float dx = static_cast<float>(x) - cx;
      const float dark = vignetting * (dx * dx + dy * dy) / (cx * cx + cy * cy);
      const float light = gain * (1 - dark);
      for (int channel = 0; channel < 3; ++channel) {
        float value = light * exact(y, x)[channel];
        if (sigma > 0) value += sigma * random.normal();
        image(y, x)[channel] = static_cast<uchar>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
      }
    }
  });
  return image;
}

// The pixels whose pattern point the projector cannot reach: it stands kBaseline to the right, so
// near things leave a shadow on their left. Read from right to left, projector columns must fall.
void drop_shadows(const cv::Mat_<float>& exact, cv::Mat_<float>& depth, double focal_length,
                  int threads) {
  constexpr float kTolerance = 0.5F;  // [px]
  const auto scale = static_cast<float>(focal_length * kBaseline);
  for_each_block(exact.rows, threads, [&](int y) {
    float leftmost = std::numeric_limits<float>::infinity();  // projector column so far [px]
    for (int x = exact.cols - 1; x >= 0; --x) {
      const float column = static_cast<float>(x) - scale / exact(y, x);
      if (column > leftmost + kTolerance) depth(y, x) = kNone;
      leftmost = std::min(leftmost, column);
    }
  });
}

// Unit noise that neighbours up to `radius` pixels away have in common.
cv::Mat_<float> shared_noise(const cv::Size& size, const Shot& shot, int radius) {
  cv::Mat_<float> noise(size);
  for_each_block(size.height, shot.threads, [&](int y) {
    Random random = shot.row(kDepthStream, y);
    for (int x = 0; x < size.width; ++x) noise(y, x) = random.normal();
  });
  const int side = 2 * radius + 1;
  cv::boxFilter(noise, noise, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_REFLECT_101);
  noise /= side;  // the sum of side^2 unit variances has the variance side^2
  return noise;
}

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
    return disparity > 0 ? static_cast<float>(kDisparityScale / disparity) : kNone;
  }
};

bool is_missing(const Shot& shot, int x, int y) {
  if (shot.options.missing_share <= 0) return false;
  Random random{shot.seed, shot.frame, kMissingStream,
                static_cast<std::uint64_t>(y / kMissingBlock),
                static_cast<std::uint64_t>(x / kMissingBlock)};
  return random.uniform() < shot.options.missing_share;
}

cv::Mat_<float> measured_depth(const Render& exact, const Shot& shot, double focal_length) {
  const SensorOptions& options = shot.options;
  cv::Mat_<float> visible = exact.depth.clone();
  drop_shadows(exact.depth, visible, focal_length, shot.threads);
  cv::Mat_<float> shared;  // empty: each pixel has noise of its own
  if (options.depth_correlation > 0)
    shared = shared_noise(visible.size(), shot, options.depth_correlation);
  const DisparityNoise measure(options);
  const auto least_incidence =
      static_cast<float>(std::cos(options.grazing_angle * std::numbers::pi / 180));
  const auto jitter = static_cast<float>(options.depth_edge_jitter);
  cv::Mat_<float> depth(visible.size(), kNone);
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
      if (std::isnan(z) || exact.incidence(from_y, from_x) < least_incidence) continue;
      if (is_missing(shot, x, y)) continue;
      const float value = measure(z, noise);
      if (value >= options.nearest && value <= options.farthest) depth(y, x) = value;
    }
  });
  return depth;
}

}  // namespace

RgbdImage sense(const Render& exact, const SensorOptions& options, double focal_length,
                double seconds, std::uint64_t seed, std::uint64_t frame, int threads) {
  const Shot shot{.options = options, .seed = seed, .frame = frame, .threads = threads};
  return {.stamp = {},
          .bgr = colour(exact.bgr, shot, seconds),
          .depth = options.noise ? measured_depth(exact, shot, focal_length) : exact.depth};
}

}  // namespace edvo::synth
