// SPDX-License-Identifier: MIT
// What every stage of a sensor's model needs to know of a frame, and noise that pixels share.
#pragma once

#include "edvo/synth/random.hpp"
#include "edvo/synth/render.hpp"
#include "edvo/synth/sensor.hpp"

#include <limits>
#include <opencv2/core.hpp>

namespace edvo::synth {

inline constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

// Independent streams of random numbers of one frame.
enum Stream : std::uint64_t {
  kColourStream,
  kDepthStream,
  kJitterStream,
  kMissingStream,
  kSpeckleStream,
  kBiasStream,
};

struct Shot {
  const SensorOptions& options;
  double focal_length = 0;  // [px]
  std::uint64_t seed = 0, frame = 0;
  int threads = 0;

  [[nodiscard]] Random row(Stream stream, int y) const {
    return Random{seed, frame, stream, static_cast<std::uint64_t>(y)};
  }
};

// Unit noise that neighbours up to `radius` pixels away have in common.
[[nodiscard]] cv::Mat_<float> shared_noise(const cv::Size& size, const Shot& shot, int radius);

// Noise in [-1..1] that varies smoothly over `cell` pixels and over kBiasFrames frames: what an
// algorithm gets wrong in the same way for a while.
[[nodiscard]] cv::Mat_<float> smooth_noise(const cv::Size& size, const Shot& shot, int cell);

// Takes away the pixels that only one of two devices sees, of which the second stands `baseline`
// [m] to the right: near things leave a shadow on their left.
void drop_shadows(const cv::Mat_<float>& exact, cv::Mat_<float>& depth, const Shot& shot,
                  double baseline);

[[nodiscard]] float least_incidence(const SensorOptions& options);  // cosine

}  // namespace edvo::synth
