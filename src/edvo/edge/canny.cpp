// SPDX-License-Identifier: MIT
#include "edvo/edge/canny.hpp"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

constexpr int kHighestMagnitude = 2048;    // of the 3x3 Sobel on 8 bits, L1 norm: 2 * 4 * 255
constexpr double kLowestThreshold = 16.0;  // below, sensor noise on a blank wall would be edges

// The magnitude that the given share of all pixels exceeds.
double magnitude_quantile(const cv::Mat_<short>& gx, const cv::Mat_<short>& gy, double share) {
  std::array<int, kHighestMagnitude + 1> histogram{};
  for (int y = 0; y < gx.rows; ++y) {
    const short* row_x = gx[y];
    const short* row_y = gy[y];
    for (int x = 0; x < gx.cols; ++x)
      ++histogram[static_cast<std::size_t>(std::abs(row_x[x]) + std::abs(row_y[x]))];
  }
  const double wanted = share * static_cast<double>(gx.total());
  double above = 0;
  int magnitude = kHighestMagnitude;
  while (magnitude > 0 && (above += histogram[static_cast<std::size_t>(magnitude)]) < wanted)
    --magnitude;
  return magnitude;
}

}  // namespace

cv::Mat_<std::uint8_t> canny_edges(const cv::Mat_<std::uint8_t>& gray,
                                   const CannyOptions& options) {
  cv::Mat smooth = gray;
  if (options.blur_sigma > 0) cv::GaussianBlur(gray, smooth, {}, options.blur_sigma);
  cv::Mat_<short> gx, gy;
  cv::Sobel(smooth, gx, CV_16S, 1, 0);
  cv::Sobel(smooth, gy, CV_16S, 0, 1);
  const double high = std::max(kLowestThreshold, magnitude_quantile(gx, gy, options.edge_share));
  cv::Mat_<std::uint8_t> edges;
  cv::Canny(gx, gy, edges, options.low_ratio * high, high);
  return edges;
}

}  // namespace edvo
