// SPDX-License-Identifier: MIT
// How many units of a depth image make a metre, and whether that can be right.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace edvo {

struct DepthScale {
  double units_per_metre = 5000;
  std::string source;  // why this one, as half a sentence
};

// The median of the pixels that have depth, none if no pixel has. [m]
[[nodiscard]] std::optional<double> median_depth(const cv::Mat_<float>& depth);

// Empty if a scene of that median depth [m] is plausible (0.1 to 20 m); otherwise a warning that
// names the usual scale which fits best.
[[nodiscard]] std::optional<std::string> check_depth_scale(double median, const DepthScale& scale);

}  // namespace edvo
