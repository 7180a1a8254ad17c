// SPDX-License-Identifier: MIT
#include "edvo/synth/shot.hpp"

#include "edvo/synth/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace edvo::synth {

cv::Mat_<float> shared_noise(const cv::Size& size, const Shot& shot, int radius) {
  cv::Mat_<float> noise(size);
  for_each_block(size.height, shot.threads, [&](int y) {
    Random random = shot.row(kDepthStream, y);
    for (int x = 0; x < size.width; ++x) noise(y, x) = random.normal();
  });
  const int side = 2 * radius + 1;
  cv::boxFilter(noise, noise, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_REFLECT_101);
  noise /= side;  // the sum of side^2 unit variances has the variance side^2
  return noise;
}

cv::Mat_<float> smooth_noise(const cv::Size& size, const Shot& shot, int cell) {
  constexpr std::uint64_t kBiasFrames = 16;
  const cv::Size cells(size.width / cell + 2, size.height / cell + 2);
  const std::uint64_t period = shot.frame / kBiasFrames;
  const float share = static_cast<float>(shot.frame % kBiasFrames) / kBiasFrames;
  cv::Mat_<float> coarse(cells);
  for (int y = 0; y < cells.height; ++y) {
    const auto row = static_cast<std::uint64_t>(y);
    Random before{shot.seed, period, kBiasStream, row},
        after{shot.seed, period + 1, kBiasStream, row};
    for (int x = 0; x < cells.width; ++x)
      coarse(y, x) = (1 - share) * static_cast<float>(before.uniform(-1, 1)) +
                     share * static_cast<float>(after.uniform(-1, 1));
  }
  cv::Mat_<float> fine;
  cv::resize(coarse, fine, cells * cell, 0, 0, cv::INTER_LINEAR);
  return fine(cv::Rect(cv::Point(cell / 2, cell / 2), size)).clone();
}

// Read from right to left, columns of the second device must fall.
void drop_shadows(const cv::Mat_<float>& exact, cv::Mat_<float>& depth, const Shot& shot,
                  double baseline) {
  constexpr float kTolerance = 0.5F;  // [px]
  const auto scale = static_cast<float>(shot.focal_length * baseline);
  for_each_block(exact.rows, shot.threads, [&](int y) {
    float leftmost = std::numeric_limits<float>::infinity();  // column so far [px]
    for (int x = exact.cols - 1; x >= 0; --x) {
      const float column = static_cast<float>(x) - scale / exact(y, x);
      if (column > leftmost + kTolerance) depth(y, x) = kNoDepth;
      leftmost = std::min(leftmost, column);
    }
  });
}

float least_incidence(const SensorOptions& options) {
  return static_cast<float>(std::cos(options.grazing_angle * std::numbers::pi / 180));
}

}  // namespace edvo::synth
