// SPDX-License-Identifier: MIT
// Every option of the odometry, the paper's systems as presets of them, and their text form.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/core/fields.hpp"
#include "edvo/features/canny.hpp"
#include "edvo/features/corners.hpp"
#include "edvo/features/edge_strength.hpp"
#include "edvo/window/window_keyframe.hpp"

#include <concepts>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

// The systems that the paper compares, and its ablations. Each is a preset, not a code path.
enum class Method {
  kCnnCorner,    // network edges, corner optimization (the paper's own)
  kCannyCorner,  // Canny edges, corner optimization
  kOrigin,       // dense direct method: every pixel with depth and gradient, no keyframes
  kCanny,        // Canny edges without corner optimization
  kCnn,          // network edges without corner optimization
};

inline constexpr Method kDefaultMethod = Method::kCannyCorner;  // docs/evaluation.md says why

template <>
struct EnumNames<Method> {
  static constexpr auto names = std::to_array<std::pair<Method, std::string_view>>({
      {Method::kCnnCorner, "cnn+corner"},
      {Method::kCannyCorner, "canny+corner"},
      {Method::kOrigin, "origin"},
      {Method::kCanny, "canny"},
      {Method::kCnn, "cnn"},
  });
};

enum class Detector { kNone, kCanny, kNetwork };

template <>
struct EnumNames<Detector> {
  static constexpr auto names = std::to_array<std::pair<Detector, std::string_view>>(
      {{Detector::kNone, "none"}, {Detector::kCanny, "canny"}, {Detector::kNetwork, "network"}});
};

struct EdgeOptions {
  Detector detector = Detector::kCanny;
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, EdgeOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("detector", self.detector, Range{}, "none: every pixel with depth and gradient (dense)");
}

struct MotionOptions {
  double acceleration = 10;  // [m / s^2]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, MotionOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("acceleration", self.acceleration, Range{0, 1e6},
        "sigma of the camera's acceleration: its velocity is expected to stay within that; 0 = "
        "nothing is expected [m / s^2]");
}

// When a frame becomes a keyframe (paper, section III-C, fig. 4).
// visit_fields lists the options of the program; the other fields are constants
// (docs/experiments/options.md).
struct KeyframeOptions {
  int period = 20;           // frames, 0 = never by period
  double translation = 0.1;  // [m]
  double rotation = 0.15;    // [rad]
  double overlap = 0.7;      // [0..1]
  double inliers = 0.6;      // [0..1]
  double blur_ratio = 1.3;   // [1]
  int max_lost_frames = 2;   // frames
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, KeyframeOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("period", self.period, Range{0, 1e6}, "frames after which a keyframe is due; 0 = never");
  visit("translation", self.translation, Range{0, 1e6},
        "motion amplitude Omega, translation part, at which one is due [m]");
  visit("rotation", self.rotation, Range{0, 1e6},
        "motion amplitude Omega, rotation part, at which one is due [rad]");
  visit("overlap", self.overlap, Range{0, 1}, "share of points in view below which one is due");
  visit("max_lost_frames", self.max_lost_frames, Range{0, 1e6},
        "lost frames in a row after which a new segment begins at the last good pose");
}

struct Config {
  EdgeOptions edge;
  CannyOptions canny;
  NetworkOptions network;
  CornerOptions corners;
  SelectOptions selection;
  MotionOptions motion;
  AlignOptions tracking;
  KeyframeOptions keyframes;
  WindowOptions window;
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, Config>
void visit_groups(Self& self, Visitor&& visit) {
  visit("edge", self.edge, "where edges come from");
  visit("canny", self.canny, "Canny edges");
  visit("network", self.network, "edges by a network (section III-A)");
  visit("corners", self.corners, "Shi-Tomasi corner optimization (section III-B)");
  visit("selection", self.selection, "which pixels of a keyframe are tracked");
  visit("motion", self.motion, "what is expected of the camera's motion");
  visit("tracking", self.tracking, "alignment of a frame (section III-D)");
  visit("keyframes", self.keyframes, "when a frame becomes a keyframe (section III-C)");
  visit("window", self.window, "joint refinement of the last keyframes");
}

// The options of one of the paper's systems.
[[nodiscard]] Config preset(Method method);

// The same options as TOML, one [group] each, every field with its help as a comment.
[[nodiscard]] std::string to_toml(const Config& config);

// Reads options over those of base. Unknown keys, wrong types and values out of range throw
// Error(kConfig) naming source, line, key and value, and the nearest known key.
[[nodiscard]] Config config_from_toml(std::string_view text, const std::string& source,
                                      Config base);

// Applies "group.field=value" (the value spelled as in TOML; quotes around strings optional).
void set_option(Config& config, std::string_view assignment);

// Throws Error(kConfig) at the first value out of its range. NaN is out of every range.
void check(const Config& config);

}  // namespace edvo
