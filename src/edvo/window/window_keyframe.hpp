// SPDX-License-Identifier: MIT
// Joint photometric refinement of a window of keyframes: poses, brightness and inverse depths
// (after Engel, Koltun, Cremers 2018, Direct Sparse Odometry, with measured depth as a prior).
#pragma once

#include "edvo/core/se3.hpp"
#include "edvo/features/pixel_selection.hpp"

#include <array>
#include <concepts>
#include <cstdint>
#include <limits>
#include <vector>

namespace edvo {

// visit_fields lists the options of the program; the other fields are constants
// (docs/experiments/options.md).
struct WindowOptions {
  int keyframes = 7;
  int fixed_keyframes = 5;
  int candidate_keyframes = 300;
  int points = 300;
  int iterations = 5;
  int final_iterations = 8;
  double tolerance = 5e-4;
  double sigma = 2.0;                   // [grey levels]
  double huber = 1.345;                 // [sigmas]
  double pair_sigma_scale = 0.6;        // [1]
  double gradient_weight_scale = 50.0;  // [grey levels / px]
  double depth_noise = 0.0015;          // [1 / m]
  double depth_bias = 0.003;
  double depth_weight = 0.5;
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, WindowOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("keyframes", self.keyframes, Range{0, 50}, "keyframes refined together; 0 = no refinement");
  visit("fixed_keyframes", self.fixed_keyframes, Range{1, 50},
        "older keyframes with the same view that hold the refined ones in place");
  visit("candidate_keyframes", self.candidate_keyframes, Range{1, 10000},
        "older keyframes kept as possible fixed_keyframes and for the last refinement");
  visit("points", self.points, Range{10, 1e6}, "points per keyframe in the refinement");
  visit("final_iterations", self.final_iterations, Range{0, 1000},
        "of the last refinement, of all keyframes together; 0 = none");
  visit("depth_noise", self.depth_noise, Range{1e-6, 1},
        "sigma of measured inverse depth; between keyframes less where residuals are smaller [1 / "
        "m]");
  visit("depth_weight", self.depth_weight, Range{0, 1e3},
        "weight of the depth residuals between keyframes; 0 = off");
}

// The patch around a point: offsets from its pixel, the centre first [px] (DSO's pattern).
constexpr int kPatchSize = 8;
constexpr float kPatternX[kPatchSize] = {0, 0, -1, 1, -2, 2, -1, 0};
constexpr float kPatternY[kPatchSize] = {0, -2, -1, -1, 0, 0, 1, 2};

struct WindowPoint {
  float u = 0, v = 0;                                     // level 0 [px]
  double inverse_depth = 0;                               // [1 / m]
  double measured = 0;                                    // [1 / m]
  double weight = 0;                                      // of measured [m^2]
  std::array<float, kPatchSize> intensity{};              // [grey levels]
  std::array<float, kPatchSize> gradient_weight_scale{};  // weights by gradient [0..1]
};

struct WindowKeyframe {
  std::int64_t id = 0;
  Stamp stamp;
  SE3 world_from_key;
  RollingShutter shutter;
  double gain = 1, bias = 0;    // I = gain * radiance + bias
  cv::Mat_<std::uint8_t> gray;  // level 0
  // Inverse, of every second pixel [kInverseDepthStep]; 0 = none or on a jump.
  cv::Mat_<std::uint16_t> half_depth;
  std::vector<WindowPoint> points;
};

// [1 / m] Much less than any sensor's noise; depths from 0.13 m on can be told.
constexpr float kInverseDepthStep = 1.2e-4F;

// Inverse depth at the nearest of those pixels that have one [1 / m], NaN = none. u, v: at most the
// image's size less two [px]; beyond, the nearest may lie outside.
[[nodiscard]] inline float inverse_depth_at(const WindowKeyframe& key, float u, float v) {
  const std::uint16_t steps =
      key.half_depth(static_cast<int>(0.5F * v + 0.5F), static_cast<int>(0.5F * u + 0.5F));
  return steps > 0 ? kInverseDepthStep * static_cast<float>(steps)
                   : std::numeric_limits<float>::quiet_NaN();
}

[[nodiscard]] WindowKeyframe make_window_keyframe(const Frame& frame, const SE3& world_from_key,
                                                  const std::vector<SelectedPixel>& pixels,
                                                  const WindowOptions& options);

// Share of the points of one keyframe that another sees, [0..1]: its image has them, and nothing
// else there.
[[nodiscard]] double shared_view(const WindowKeyframe& host, const WindowKeyframe& target,
                                 const Camera& camera);

}  // namespace edvo
