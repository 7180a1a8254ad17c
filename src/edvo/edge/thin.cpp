// SPDX-License-Identifier: MIT
#include "edvo/edge/thin.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Strength saturates along the middle of a broad edge; smoothing gives it a crest again. The kernel
// reaches 4 sigma: enough for bands of 7 px, little enough to keep parallel edges apart.
constexpr double kSmoothing = 1.0;  // [px]

// Closer than this, two strengths differ by rounding only.
constexpr float kTie = 1e-6F;

// The image with a border of one pixel, so that neighbours need no test.
cv::Mat_<float> with_border(const cv::Mat_<float>& image) {
  cv::Mat padded;
  cv::copyMakeBorder(image, padded, 1, 1, 1, 1, cv::BORDER_REPLICATE);
  return padded;
}

// Unit normal of the ridge at a pixel: where the surface bends down most, the eigenvector of the
// smallest eigenvalue of its Hessian. Of the two opposite ones always the right or lower, so that
// ties are broken the same way all along an edge.
cv::Point2f ridge_normal(const cv::Mat_<float>& s, int x, int y) {
  const float xx = s(y, x + 1) - 2 * s(y, x) + s(y, x - 1);
  const float yy = s(y + 1, x) - 2 * s(y, x) + s(y - 1, x);
  const float xy = 0.25F * (s(y + 1, x + 1) - s(y + 1, x - 1) - s(y - 1, x + 1) + s(y - 1, x - 1));
  const float angle = 0.5F * std::atan2(-2 * xy, yy - xx);  // in [-pi/2, pi/2]
  const cv::Point2f normal(std::cos(angle), std::sin(angle));
  return 2 * normal.x + normal.y >= 0 ? normal : -normal;
}

// Bilinear, at most one pixel away from (x, y).
float sample(const cv::Mat_<float>& s, int x, int y, cv::Point2f offset) {
  const int left = offset.x < 0 ? x - 1 : x;
  const int top = offset.y < 0 ? y - 1 : y;
  const float u = offset.x < 0 ? offset.x + 1 : offset.x;
  const float v = offset.y < 0 ? offset.y + 1 : offset.y;
  const int right = u > 0 ? left + 1 : left;
  const int bottom = v > 0 ? top + 1 : top;
  return (1 - v) * ((1 - u) * s(top, left) + u * s(top, right)) +
         v * ((1 - u) * s(bottom, left) + u * s(bottom, right));
}

}  // namespace

cv::Mat_<std::uint8_t> thin_edges(const cv::Mat_<float>& strength, double threshold) {
  cv::Mat_<float> smooth;
  cv::GaussianBlur(strength, smooth, {}, kSmoothing, kSmoothing, cv::BORDER_REPLICATE);
  const cv::Mat_<float> s = with_border(smooth);
  cv::Mat_<std::uint8_t> thin(strength.size(), std::uint8_t{0});
  for (int y = 0; y < strength.rows; ++y)
    for (int x = 0; x < strength.cols; ++x) {
      if (strength(y, x) < threshold) continue;
      const cv::Point2f normal = ridge_normal(s, x + 1, y + 1);
      const float here = s(y + 1, x + 1);
      if (here > sample(s, x + 1, y + 1, normal) - kTie &&
          here > sample(s, x + 1, y + 1, -normal) + kTie)
        thin(y, x) = 255;
    }
  return thin;
}

}  // namespace edvo
