// SPDX-License-Identifier: MIT
// What an RGB-D camera makes of an exact picture.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/core/rgbd_image.hpp"
#include "edvo/synth/random.hpp"
#include "edvo/synth/render.hpp"

#include <array>
#include <concepts>
#include <string_view>
#include <utility>

namespace edvo::synth {

// How depth is measured, and so what is wrong with it (depth_models.hpp).
enum class SensorKind {
  kKinect1,     // structured light
  kIcl,         // the same as in the ICL-NUIM sequences: stray depths at edges
  kTof,         // time of flight
  kStereo,      // active stereo
  kLidarPhone,  // few points, completed
  kClean,       // exact depth and colour, as without noise
};

struct SensorOptions {
  SensorKind kind = SensorKind::kKinect1;
  bool noise = true;                 // false: exact depth, exact colour rounded to 8 bits
  double depth_noise = 1.4e-3;       // [1/m]
  int depth_correlation = 0;         // [px]
  double disparity_step = 0.125;     // [px]
  double depth_edge_jitter = 0.5;    // [px]
  double grazing_angle = 80;         // [deg]
  double nearest = 0.4;              // [m]
  double farthest = 5.0;             // [m]
  double missing_share = 0;          // [0..1]
  double depth_delay = 0;            // [s]
  double colour_noise = 2.0;         // [grey levels]
  double shot_noise = 0;             // [grey levels]
  double light = 1;                  // (0..1]
  double exposure_amplitude = 0.04;  // [1]
  double exposure_period = 5.0;      // [s]
  double exposure_jump = 1.0;        // [1]
  double exposure_jump_time = 2.0;   // [s]
  double vignetting = 0;             // [0..1]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, SensorOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("sensor", self.kind, Range{}, "how depth is measured");
  visit("noise", self.noise, Range{}, "false: exact depth, colour only rounded to 8 bits");
  visit("depth_noise", self.depth_noise, Range{0, 0.1},
        "of kinect1, axial: sigma_z = this * z^2, quantization included [1/m]");
  visit("depth_correlation", self.depth_correlation, Range{0, 10},
        "of kinect1: neighbours up to this far share their depth noise [px]");
  visit("disparity_step", self.disparity_step, Range{0, 4},
        "of kinect1: disparity quantization [px]");
  visit("depth_edge_jitter", self.depth_edge_jitter, Range{0, 5},
        "of kinect1: depth is read this far off (sigma), which frays its edges [px]");
  visit("grazing_angle", self.grazing_angle, Range{0, 90},
        "of kinect1 and icl: no depth from surfaces seen under more than this [deg]");
  visit("nearest", self.nearest, Range{0, 10}, "no depth below [m]");
  visit("farthest", self.farthest, Range{0, 100}, "no depth beyond [m]");
  visit("missing_share", self.missing_share, Range{0, 1}, "share of depth missing, in blocks");
  visit("depth_delay", self.depth_delay, Range{0, 1},
        "depth is this much older than its stamp; lidar_phone adds 1/30 s [s]");
  visit("colour_noise", self.colour_noise, Range{0, 100},
        "sigma of the noise that does not depend on brightness [grey levels]");
  visit("shot_noise", self.shot_noise, Range{0, 100},
        "variance of the noise per grey level of brightness [grey levels]");
  visit("light", self.light, Range{0.01, 1},
        "share of the usual light; amplified to the same brightness, with more noise");
  visit("exposure_amplitude", self.exposure_amplitude, Range{0, 0.9},
        "exposure rolls by this share up and down");
  visit("exposure_period", self.exposure_period, Range{0.1, 1000}, "of that roll [s]");
  visit("exposure_jump", self.exposure_jump, Range{0.1, 10}, "exposure changes by this factor");
  visit("exposure_jump_time", self.exposure_jump_time, Range{0, 1e6}, "at this time [s]");
  visit("vignetting", self.vignetting, Range{0, 1}, "light lost in the corners");
}

// How much older than its stamp depth is [s].
[[nodiscard]] double depth_delay(const SensorOptions& options);

// seconds: time since the start of the sequence; focal_length [px] of the colour camera. The key
// (seed, frame) makes the noise.
[[nodiscard]] RgbdImage sense(const Render& exact, const SensorOptions& options,
                              double focal_length, double seconds, std::uint64_t seed,
                              std::uint64_t frame, int threads);

}  // namespace edvo::synth

template <>
struct edvo::EnumNames<edvo::synth::SensorKind> {
  using SensorKind = edvo::synth::SensorKind;
  static constexpr auto names = std::to_array<std::pair<SensorKind, std::string_view>>({
      {SensorKind::kKinect1, "kinect1"},
      {SensorKind::kIcl, "icl"},
      {SensorKind::kTof, "tof"},
      {SensorKind::kStereo, "stereo"},
      {SensorKind::kLidarPhone, "lidar_phone"},
      {SensorKind::kClean, "clean"},
  });
};
