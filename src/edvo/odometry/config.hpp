// SPDX-License-Identifier: MIT
// Every option of the odometry, the paper's systems as presets of them, and their text form.
#pragma once

#include "edvo/core/fields.hpp"

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

struct FrameOptions {
  int levels = 4;  // pyramid levels, the full image included
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, FrameOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("levels", self.levels, Range{1, 8}, "pyramid levels, the full image included (abstract)");
}

struct Config {
  FrameOptions frame;
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, Config>
void visit_groups(Self& self, Visitor&& visit) {
  visit("frame", self.frame, "what is computed from each image");
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
