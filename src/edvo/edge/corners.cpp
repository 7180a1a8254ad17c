// SPDX-License-Identifier: MIT
#include "edvo/edge/corners.hpp"

#include "edvo/core/simd.hpp"

#include <algorithm>
#include <array>
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

// Half of a Gaussian kernel, its centre first.
std::vector<float> gaussian(double sigma) {
  const int radius = static_cast<int>(std::ceil(4 * sigma));
  std::vector<float> half;
  double sum = 0;
  for (int i = 0; i <= radius; ++i) {
    half.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma))));
    sum += (i == 0 ? 1 : 2) * static_cast<double>(half.back());
  }
  for (float& weight : half) weight /= static_cast<float>(sum);
  return half;
}

// Row by row, so that everything between the image and the response stays in the cache.
struct RowBuffers {
  RowBuffers(int columns, int radius) {
    for (auto& row : products) row.resize(static_cast<std::size_t>(columns + 2 * radius));
    for (auto& row : sums) row.resize(static_cast<std::size_t>(columns));
  }
  std::array<std::vector<float>, 3> products;  // xx, xy, yy
  std::array<std::vector<float>, 3> sums;      // of them over the window
};

// Squares and product of Sobel's gradient, from three rows of count + 2 pixels.
EDVO_CLONES void gradient_products(const float* above, const float* row, const float* below,
                                   int count, RowBuffers& buffers) {
  float* __restrict xx = buffers.products[0].data();
  float* __restrict xy = buffers.products[1].data();
  float* __restrict yy = buffers.products[2].data();
  for (int x = 0; x < count; ++x) {
    const float gx = 0.125F * ((above[x + 2] - above[x]) + 2 * (row[x + 2] - row[x]) +
                               (below[x + 2] - below[x]));
    const float gy = 0.125F * ((below[x] - above[x]) + 2 * (below[x + 1] - above[x + 1]) +
                               (below[x + 2] - above[x + 2]));
    xx[x] = gx * gx;
    xy[x] = gx * gy;
    yy[x] = gy * gy;
  }
}

// in: count + 2 radius values.
EDVO_CLONES void blur_row(const float* in, const std::vector<float>& kernel, int count,
                          float* __restrict out) {
  const int radius = static_cast<int>(kernel.size()) - 1;
  const float* centre = in + radius;
  for (int x = 0; x < count; ++x) out[x] = kernel[0] * centre[x];
  for (int i = 1; i <= radius; ++i) {
    const float weight = kernel[static_cast<std::size_t>(i)];
    for (int x = 0; x < count; ++x) out[x] += weight * (centre[x - i] + centre[x + i]);
  }
}

// Around row `middle` of a ring of `length` rows that starts at row `first` of the matrix.
EDVO_CLONES void blur_column(const cv::Mat_<float>& ring, int first, int length, int middle,
                             const std::vector<float>& kernel, float* __restrict out) {
  const float* centre = ring[first + middle % length];
  for (int x = 0; x < ring.cols; ++x) out[x] = kernel[0] * centre[x];
  for (int i = 1; i < static_cast<int>(kernel.size()); ++i) {
    const float weight = kernel[static_cast<std::size_t>(i)];
    const float* above = ring[first + (middle - i) % length];
    const float* below = ring[first + (middle + i) % length];
    for (int x = 0; x < ring.cols; ++x) out[x] += weight * (above[x] + below[x]);
  }
}

EDVO_CLONES void smaller_eigenvalue(const float* xx, const float* xy, const float* yy, int count,
                                    float* __restrict out) {
  for (int x = 0; x < count; ++x) {
    const float mean = 0.5F * (xx[x] + yy[x]);
    const float half = 0.5F * (xx[x] - yy[x]);
    out[x] = mean - std::sqrt(half * half + xy[x] * xy[x]);
  }
}

}  // namespace

cv::Mat_<float> min_eigenvalue(const cv::Mat_<float>& image, double window_sigma) {
  const std::vector<float> kernel = gaussian(window_sigma);
  const int radius = static_cast<int>(kernel.size()) - 1;
  cv::Mat_<float> wide;  // one more pixel all around for the differences
  cv::copyMakeBorder(image, wide, radius + 1, radius + 1, radius + 1, radius + 1,
                     cv::BORDER_REFLECT_101);
  const int length = 2 * radius + 1;
  RowBuffers buffers(image.cols, radius);
  cv::Mat_<float> blurred(3 * length, image.cols);  // the last rows of xx, xy and yy, in a ring
  cv::Mat_<float> response(image.size());
  for (int y = 0; y < wide.rows - 2; ++y) {
    gradient_products(wide[y], wide[y + 1], wide[y + 2], wide.cols - 2, buffers);
    const int slot = y % length;
    for (int p = 0; p < 3; ++p)
      blur_row(buffers.products[static_cast<std::size_t>(p)].data(), kernel, image.cols,
               blurred[p * length + slot]);
    if (y < 2 * radius) continue;
    for (int p = 0; p < 3; ++p)
      blur_column(blurred, p * length, length, y - radius, kernel,
                  buffers.sums[static_cast<std::size_t>(p)].data());
    smaller_eigenvalue(buffers.sums[0].data(), buffers.sums[1].data(), buffers.sums[2].data(),
                       image.cols, response[y - 2 * radius]);
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
