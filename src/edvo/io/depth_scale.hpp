// SPDX-License-Identifier: MIT
// How many units of a depth image make a metre, and whether the values can be depth at all.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

struct DepthScale {
  double units_per_metre = 5000;
  std::string source;       // why this one, as half a sentence
  bool is_assumed = false;  // neither given nor stated nor known by the camera
};

// The usual scale within 15 % of this one, or itself. [units/m]
[[nodiscard]] double nearest_usual_scale(double units_per_metre);

// The values of some depth images, by how often each occurs.
struct DepthValues {
  std::vector<std::int64_t> counts = std::vector<std::int64_t>(65536);  // pixels of each value
  int images = 0;
};

void add_image(DepthValues& values, const cv::Mat_<std::uint16_t>& raw);

// Of the pixels that have depth: neither 0 (no return) nor 65535 (saturated). None if no pixel has.
[[nodiscard]] std::optional<int> median_value(const DepthValues& values);

struct DepthFindings {
  std::vector<std::string> notes;     // what is read as what
  std::vector<std::string> warnings;  // what looks wrong, and what would mend it
};

// Whether a scene of that depth is plausible (median of 0.1 to 20 m), which usual scale would make
// it so, and whether sensors give such values at all. A scale that is advised is one that passes.
[[nodiscard]] DepthFindings check_depth(const DepthValues& values, const DepthScale& scale);

}  // namespace edvo
