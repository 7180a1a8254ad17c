// SPDX-License-Identifier: MIT
#include "edvo/edge/canny.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace edvo {
namespace {

constexpr int kHighestMagnitude = 2048;    // of the 3x3 Sobel on 8 bits, L1 norm: 2 * 4 * 255
constexpr double kLowestThreshold = 16.0;  // below, sensor noise on a blank wall would be edges

// Weighted gradients are kept in eighths, or rounding would make plateaus of weak edges.
constexpr int kWeightedUnit = 8;

void multiply(cv::Mat_<short>& gradient, const cv::Mat_<float>& weights) {
  for (int y = 0; y < gradient.rows; ++y) {
    short* row = gradient[y];
    const float* weight = weights[y];
    for (int x = 0; x < gradient.cols; ++x) {
      const float g = kWeightedUnit * weight[x] * static_cast<float>(row[x]);
      row[x] = static_cast<short>(g + std::copysign(0.5F, g));
    }
  }
}

// The magnitude that the given share of all pixels exceeds.
int magnitude_quantile(const cv::Mat_<short>& gx, const cv::Mat_<short>& gy, int highest,
                       double share) {
  std::vector<int> histogram(static_cast<std::size_t>(highest) + 1);
  for (int y = 0; y < gx.rows; ++y) {
    const short* row_x = gx[y];
    const short* row_y = gy[y];
    for (int x = 0; x < gx.cols; ++x)
      ++histogram[static_cast<std::size_t>(std::abs(row_x[x]) + std::abs(row_y[x]))];
  }
  const double wanted = share * static_cast<double>(gx.total());
  double above = 0;
  int magnitude = highest;
  while (magnitude > 0 && (above += histogram[static_cast<std::size_t>(magnitude)]) < wanted)
    --magnitude;
  return magnitude;
}

}  // namespace

cv::Mat_<std::uint8_t> canny_edges(const cv::Mat_<std::uint8_t>& gray, const CannyOptions& options,
                                   const cv::Mat_<float>& weights) {
  cv::Mat smooth;
  if (options.blur_sigma > 0)
    cv::GaussianBlur(gray, smooth, {}, options.blur_sigma);
  else
    smooth = gray;
  cv::Mat_<short> gx, gy;
  cv::Sobel(smooth, gx, CV_16S, 1, 0);
  cv::Sobel(smooth, gy, CV_16S, 0, 1);
  const int unit = weights.empty() ? 1 : kWeightedUnit;
  if (!weights.empty()) {
    multiply(gx, weights);
    multiply(gy, weights);
  }
  const int strong = magnitude_quantile(gx, gy, unit * kHighestMagnitude, options.edge_share);
  const double high = std::max<double>(unit * kLowestThreshold, strong);
  cv::Mat_<std::uint8_t> edges;
  cv::Canny(gx, gy, edges, options.low_ratio * high, high);
  return edges;
}

}  // namespace edvo
