// SPDX-License-Identifier: MIT
#include "edvo/synth/sensor.hpp"

#include "edvo/synth/depth_models.hpp"
#include "edvo/synth/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace edvo::synth {
namespace {

constexpr int kMissingBlock = 8;  // [px]

bool is_exact(const SensorOptions& options) {
  return !options.noise || options.kind == SensorKind::kClean;
}

double exposure(const SensorOptions& options, double seconds) {
  const double roll = 1 + options.exposure_amplitude *
                              std::sin(2 * std::numbers::pi * seconds / options.exposure_period);
  return seconds < options.exposure_jump_time ? roll : roll * options.exposure_jump;
}

cv::Mat_<cv::Vec3b> colour(const cv::Mat_<cv::Vec3f>& exact, const Shot& shot, double seconds) {
  const SensorOptions& options = shot.options;
  const bool noise = !is_exact(options);
  const auto gain = static_cast<float>(noise ? exposure(options, seconds) : 1);
  const auto sigma = static_cast<float>(noise ? options.colour_noise / options.light : 0);
  const auto per_level = static_cast<float>(noise ? options.shot_noise / options.light : 0);
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
        const float variance = sigma * sigma + per_level * value;
        if (variance > 0) value += std::sqrt(variance) * random.normal();
        image(y, x)[channel] = static_cast<uchar>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
      }
    }
  });
  return image;
}

bool is_missing(const Shot& shot, int x, int y) {
  if (shot.options.missing_share <= 0) return false;
  Random random{shot.seed, shot.frame, kMissingStream,
                static_cast<std::uint64_t>(y / kMissingBlock),
                static_cast<std::uint64_t>(x / kMissingBlock)};
  return random.uniform() < shot.options.missing_share;
}

cv::Mat_<float> depth_of_kind(const Render& exact, const Shot& shot) {
  switch (shot.options.kind) {
    case SensorKind::kKinect1:
      return kinect1_depth(exact, shot);
    case SensorKind::kIcl:
      return icl_depth(exact, shot);
    case SensorKind::kTof:
      return tof_depth(exact, shot);
    case SensorKind::kStereo:
      return stereo_depth(exact, shot);
    case SensorKind::kLidarPhone:
      return lidar_phone_depth(exact, shot);
    case SensorKind::kClean:
      break;
  }
  return exact.depth;
}

// Strays of icl lie nearer than any range that a sensor is given, and stay, as in its sequences.
cv::Mat_<float> measured_depth(const Render& exact, const Shot& shot) {
  const SensorOptions& options = shot.options;
  cv::Mat_<float> depth = depth_of_kind(exact, shot);
  const double nearest = options.kind == SensorKind::kIcl ? 0 : options.nearest;
  for_each_block(depth.rows, shot.threads, [&](int y) {
    for (int x = 0; x < depth.cols; ++x) {
      float& z = depth(y, x);
      if (!(z >= nearest && z <= options.farthest) || is_missing(shot, x, y)) z = kNoDepth;
    }
  });
  return depth;
}

}  // namespace

double depth_delay(const SensorOptions& options) {
  constexpr double kLidarDelay = 1.0 / 30;  // [s]
  if (is_exact(options)) return 0;
  return options.depth_delay + (options.kind == SensorKind::kLidarPhone ? kLidarDelay : 0);
}

RgbdImage sense(const Render& exact, const SensorOptions& options, double focal_length,
                double seconds, std::uint64_t seed, std::uint64_t frame, int threads) {
  const Shot shot{.options = options,
                  .focal_length = focal_length,
                  .seed = seed,
                  .frame = frame,
                  .threads = threads};
  return {.stamp = {},
          .bgr = colour(exact.bgr, shot, seconds),
          .depth = is_exact(options) ? exact.depth : measured_depth(exact, shot)};
}

}  // namespace edvo::synth
