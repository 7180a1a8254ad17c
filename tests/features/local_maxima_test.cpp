// SPDX-License-Identifier: MIT
#include "edvo/features/local_maxima.hpp"

#include <gtest/gtest.h>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Noise, blurred, and in steps: equal neighbours are where rules for maxima differ.
cv::Mat_<std::uint8_t> noise(cv::RNG& random, double sigma, int step) {
  cv::Mat_<std::uint8_t> image(random.uniform(1, 60), random.uniform(1, 60));
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  if (sigma > 0) cv::GaussianBlur(image, image, {}, sigma);
  for (std::uint8_t& v : image) v = static_cast<std::uint8_t>(v / step * step);
  return image;
}

TEST(ConnectedMaxima, AreCannysForAnySize) {
  cv::RNG random(7);
  for (int i = 0; i < 600; ++i) {
    const cv::Mat_<std::uint8_t> image = noise(random, 0.8 * (i % 4), 1 << (i % 6));
    cv::Mat_<std::int16_t> x, y;
    cv::Sobel(image, x, CV_16S, 1, 0);
    cv::Sobel(image, y, CV_16S, 0, 1);
    const int high = random.uniform(1, 900), low = random.uniform(0, high + 1);
    cv::Mat_<std::uint8_t> edges;
    cv::Canny(x, y, edges, low, high);
    ASSERT_EQ(cv::norm(connected_maxima(sobel_gradients(image), low, high), edges, cv::NORM_INF), 0)
        << image.size() << " low " << low << " high " << high << " case " << i;
  }
}

TEST(ConnectedMaxima, OfWeightedGradientsAreCannys) {
  cv::RNG random(8);
  for (int i = 0; i < 100; ++i) {
    const cv::Mat_<std::uint8_t> image = noise(random, 1.0, 1);
    cv::Mat_<float> weights(image.size());
    random.fill(weights, cv::RNG::UNIFORM, 0, 1);
    cv::Mat_<std::int16_t> gradients[2];
    for (int axis = 0; axis < 2; ++axis) {
      cv::Mat_<float> g;
      cv::Sobel(image, g, CV_32F, 1 - axis, axis);
      gradients[axis].create(image.size());
      for (int k = 0; k < static_cast<int>(g.total()); ++k)
        gradients[axis](k / g.cols, k % g.cols) = static_cast<std::int16_t>(
            std::round(8 * weights(k / g.cols, k % g.cols) * g(k / g.cols, k % g.cols)));
    }
    cv::Mat_<std::uint8_t> edges;
    cv::Canny(gradients[0], gradients[1], edges, 300, 900);
    ASSERT_EQ(cv::norm(connected_maxima(sobel_gradients(image, weights, 8), 300, 900), edges,
                       cv::NORM_INF),
              0)
        << image.size() << " case " << i;
  }
}

TEST(NormQuantile, IsReachedByTheShareAskedForAndPassedByLess) {
  cv::RNG random(9);
  for (int i = 0; i < 50; ++i) {
    const cv::Mat_<std::uint8_t> image = noise(random, 1.0, 1);
    const GradientImage gradients = sobel_gradients(image);
    const cv::Mat_<std::int16_t> norms = gradients.norm(cv::Rect({1, 1}, image.size()));
    const double wanted = 0.2 * static_cast<double>(image.total());
    const int norm = norm_quantile(gradients, 0.2);
    EXPECT_TRUE(norm == 0 || cv::countNonZero(norms >= norm) >= wanted) << i;
    EXPECT_LT(cv::countNonZero(norms > norm), wanted) << i;
  }
}

}  // namespace
}  // namespace edvo
