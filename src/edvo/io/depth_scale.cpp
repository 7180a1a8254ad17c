// SPDX-License-Identifier: MIT
#include "edvo/io/depth_scale.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace edvo {
namespace {

constexpr double kNearest = 0.1, kFarthest = 20;  // [m] median of a scene that such cameras see
constexpr double kTypical = 2;                    // [m] indoors

// Millimetres, TUM, tenths of a millimetre, KITTI, centimetres, Replica. [units/m]
constexpr std::array kUsualScales = {1000.0, 5000.0, 10000.0, 256.0, 100.0, 6553.5};

}  // namespace

std::optional<double> median_depth(const cv::Mat_<float>& depth) {
  std::vector<float> values;
  values.reserve(depth.total());
  for (int y = 0; y < depth.rows; ++y)
    std::copy_if(depth[y], depth[y] + depth.cols, std::back_inserter(values),
                 [](float z) { return std::isfinite(z); });
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<std::string> check_depth_scale(double median, const DepthScale& scale) {
  if (median >= kNearest && median <= kFarthest) return std::nullopt;
  const double raw_median = median * scale.units_per_metre;
  const auto oddness = [&](double usual) {
    return std::abs(std::log(raw_median / usual / kTypical));
  };
  const double likely = *std::ranges::min_element(kUsualScales, {}, oddness);
  return fmt::format(
      "median depth is {:.3g} m at {} units per metre ({}), outside {} to {} m; with {} units per "
      "metre it would be {:.3g} m: try --depth-scale {}",
      median, scale.units_per_metre, scale.source, kNearest, kFarthest, likely, raw_median / likely,
      likely);
}

}  // namespace edvo
