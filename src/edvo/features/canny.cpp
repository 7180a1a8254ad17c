// SPDX-License-Identifier: MIT
#include "edvo/features/canny.hpp"

#include "edvo/features/local_maxima.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

constexpr int kLowestThreshold = 16;  // below, sensor noise on a blank wall would be edges

// Weighted gradients are kept in eighths, or rounding would make plateaus of weak edges.
constexpr int kWeightedUnit = 8;

}  // namespace

cv::Mat_<std::uint8_t> canny_edges(const cv::Mat_<std::uint8_t>& gray, const CannyOptions& options,
                                   const cv::Mat_<float>& weights) {
  cv::Mat_<std::uint8_t> blurred;
  if (options.blur_sigma > 0) cv::GaussianBlur(gray, blurred, {}, options.blur_sigma);
  const int unit = weights.empty() ? 1 : kWeightedUnit;
  const GradientImage gradients = sobel_gradients(blurred.empty() ? gray : blurred, weights, unit);
  const int high = std::max(unit * kLowestThreshold, norm_quantile(gradients, options.edge_share));
  return connected_maxima(gradients, static_cast<int>(std::floor(options.low_ratio * high)), high);
}

}  // namespace edvo
