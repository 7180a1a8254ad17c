// SPDX-License-Identifier: MIT
// The scale of depth images, and whether their values are plausible depths.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

struct DepthScale {
  double units_per_metre = 5000;
  std::string source;       // the reason for this scale, as part of a sentence
  bool is_assumed = false;  // neither given, nor stated in a file, nor known for the camera
};

// The usual scale within 15 % of this one, or itself. [units/m]
[[nodiscard]] double nearest_usual_scale(double units_per_metre);

// A histogram of the values of some depth images.
struct DepthValues {
  std::vector<std::int64_t> counts = std::vector<std::int64_t>(65536);  // pixels of each value
  int images = 0;
};

void add_image(DepthValues& values, const cv::Mat_<std::uint16_t>& raw);

// Of the pixels that have depth: neither 0 (no return) nor 65535 (saturated). None if no pixel has.
[[nodiscard]] std::optional<int> median_value(const DepthValues& values);

struct DepthFindings {
  std::vector<std::string> notes;     // how values are interpreted
  std::vector<std::string> warnings;  // what looks wrong, with a remedy
};

// Checks that the median depth is plausible (0.1 to 20 m), else suggests a usual scale that makes
// it so, and that a sensor can have measured such values.
[[nodiscard]] DepthFindings check_depth(const DepthValues& values, const DepthScale& scale);

}  // namespace edvo
