// SPDX-License-Identifier: MIT
// A phone's lidar.
#include "edvo/synth/depth_models.hpp"
#include "edvo/synth/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo::synth {

cv::Mat_<float> lidar_phone_depth(const Render& exact, const Shot& shot) {
  constexpr int kWidth = 256;         // of the depth map; its height follows the image's shape
  constexpr double kSmoothing = 1.2;  // sigma, pixels of the depth map
  constexpr int kBiasCell = 32;       // pixels of the depth map
  constexpr float kBias = 0.008F;     // largest deviation, share of the depth
  constexpr float kNoise = 0.001F;    // sigma, share of the depth
  const cv::Size full = exact.depth.size();
  const int width = std::min(kWidth, full.width);
  const cv::Size small(width, std::max(1, full.height * width / full.width));
  cv::Mat_<float> depth = exact.depth.clone();
  cv::patchNaNs(depth, shot.options.farthest + 1);
  cv::resize(depth, depth, small, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(depth, depth, {}, kSmoothing, kSmoothing, cv::BORDER_REFLECT_101);
  const cv::Mat_<float> bias = smooth_noise(small, shot, kBiasCell);
  for_each_block(small.height, shot.threads, [&](int y) {
    Random random = shot.row(kDepthStream, y);
    for (int x = 0; x < small.width; ++x)
      depth(y, x) *= 1 + kBias * bias(y, x) + kNoise * random.normal();
  });
  cv::resize(depth, depth, full, 0, 0, cv::INTER_LINEAR);
  return depth;
}

}  // namespace edvo::synth
