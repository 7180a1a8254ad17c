// SPDX-License-Identifier: MIT
#include "edvo/edge/corners.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Pixels whose response passes the threshold and is the largest of its 3x3 neighbourhood. Of equal
// neighbours the first in row order wins, so that a plateau gives one corner.
std::vector<Corner> local_maxima(const cv::Mat_<float>& response, float threshold) {
  std::vector<Corner> corners;
  for (int y = 1; y + 1 < response.rows; ++y) {
    const float* above = response[y - 1];
    const float* row = response[y];
    const float* below = response[y + 1];
    for (int x = 1; x + 1 < response.cols; ++x) {
      const float r = row[x];
      if (r <= threshold) continue;
      const bool first = r > above[x - 1] && r > above[x] && r > above[x + 1] && r > row[x - 1];
      const bool largest =
          r >= row[x + 1] && r >= below[x - 1] && r >= below[x] && r >= below[x + 1];
      if (first && largest) corners.push_back({{x, y}, r});
    }
  }
  return corners;
}

bool far_from_all(const cv::Point& position, const std::vector<Corner>& kept, double distance) {
  return std::none_of(kept.begin(), kept.end(), [&](const Corner& corner) {
    const cv::Point d = corner.position - position;
    return d.ddot(d) < distance * distance;
  });
}

// The second extraction of a crowded window: strongest first, fewer, better, farther apart.
std::vector<Corner> extract_again(std::vector<Corner> candidates, const CornerOptions& options) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Corner& a, const Corner& b) { return a.response > b.response; });
  std::vector<Corner> kept;
  for (const Corner& corner : candidates) {
    if (static_cast<int>(kept.size()) >= options.budget) break;
    if (corner.response < options.strict_quality * candidates.front().response) break;
    if (far_from_all(corner.position, kept, options.min_distance)) kept.push_back(corner);
  }
  return kept;
}

}  // namespace

cv::Mat_<float> min_eigenvalue(const cv::Mat_<float>& image, double window_sigma) {
  cv::Mat_<float> gx, gy;
  cv::Sobel(image, gx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(image, gy, CV_32F, 0, 1, 3, 1.0 / 8);
  cv::Mat xx = gx.mul(gx), xy = gx.mul(gy), yy = gy.mul(gy);
  for (cv::Mat* product : {&xx, &xy, &yy}) cv::GaussianBlur(*product, *product, {}, window_sigma);
  cv::Mat_<float> response(image.size());
  for (int y = 0; y < image.rows; ++y) {
    const float* row_xx = xx.ptr<float>(y);
    const float* row_xy = xy.ptr<float>(y);
    const float* row_yy = yy.ptr<float>(y);
    float* row = response[y];
    for (int x = 0; x < image.cols; ++x) {
      const float mean = 0.5F * (row_xx[x] + row_yy[x]);
      const float half = 0.5F * (row_xx[x] - row_yy[x]);
      row[x] = mean - std::sqrt(half * half + row_xy[x] * row_xy[x]);
    }
  }
  return response;
}

std::vector<Corner> optimize_corners(const cv::Mat_<float>& strength,
                                     const CornerOptions& options) {
  const cv::Mat_<float> response = min_eigenvalue(strength, options.window_sigma);
  double strongest = 0;
  cv::minMaxLoc(response, nullptr, &strongest);
  if (strongest <= 0) return {};
  const std::vector<Corner> all =
      local_maxima(response, static_cast<float>(options.quality * strongest));

  const int columns = (strength.cols + options.window - 1) / options.window;
  const int rows = (strength.rows + options.window - 1) / options.window;
  std::vector<std::vector<Corner>> windows(static_cast<std::size_t>(columns * rows));
  for (const Corner& corner : all) {
    const int index =
        corner.position.y / options.window * columns + corner.position.x / options.window;
    windows[static_cast<std::size_t>(index)].push_back(corner);
  }
  std::vector<Corner> kept;
  for (const std::vector<Corner>& window : windows) {
    const bool crowded = static_cast<int>(window.size()) > options.crowded;
    const std::vector<Corner> corners = crowded ? extract_again(window, options) : window;
    kept.insert(kept.end(), corners.begin(), corners.end());
  }
  std::stable_sort(kept.begin(), kept.end(), [](const Corner& a, const Corner& b) {
    return std::pair(a.position.y, a.position.x) < std::pair(b.position.y, b.position.x);
  });
  return kept;
}

cv::Mat_<std::uint8_t> draw_discs(cv::Size size, const std::vector<Corner>& corners, int radius) {
  cv::Mat_<std::uint8_t> mask(size, std::uint8_t{0});
  for (const Corner& corner : corners)
    cv::circle(mask, corner.position, radius, cv::Scalar(255), cv::FILLED);
  return mask;
}

}  // namespace edvo
