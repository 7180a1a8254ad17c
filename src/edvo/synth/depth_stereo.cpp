// SPDX-License-Identifier: MIT
// Active stereo: two cameras and a projected pattern.
#include "edvo/synth/depth_models.hpp"
#include "edvo/synth/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo::synth {
namespace {

constexpr double kBaseline = 0.05;  // [m]
constexpr int kBlock = 8;           // the widened border changes its width in such pieces [px]

cv::Mat_<float> exact_disparity(const Render& exact, float scale) {
  cv::Mat_<float> disparity(exact.depth.size());
  for (int y = 0; y < disparity.rows; ++y)
    for (int x = 0; x < disparity.cols; ++x) {
      const float z = exact.depth(y, x);
      disparity(y, x) = std::isnan(z) ? 0 : scale / z;
    }
  return disparity;
}

// Disparity [px] with the foreground widened beside jumps: a window that touches it matches it.
// On a slanted surface a window matches its middle, so what is nearer on one side and as much
// farther on the other is no jump.
cv::Mat_<float> widened_disparity(const cv::Mat_<float>& disparity, const Shot& shot) {
  constexpr int kNarrow = 2, kWide = 4;  // [px]
  constexpr float kJump = 0.5F;          // [px]
  const auto widened = [&](int radius) {
    const cv::Mat box = cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
    cv::Mat_<float> nearest, farthest;
    cv::dilate(disparity, nearest, box);
    cv::erode(disparity, farthest, box);
    cv::Mat_<float> result = disparity.clone();
    nearest.copyTo(result, nearest + farthest - 2 * disparity > kJump);
    return result;
  };
  cv::Mat_<float> result = widened(kNarrow);
  const cv::Mat_<float> wide = widened(kWide);
  for (int y = 0; y < result.rows; ++y)
    for (int x = 0; x < result.cols; ++x) {
      Random random{shot.seed, shot.frame, kJitterStream, static_cast<std::uint64_t>(y / kBlock),
                    static_cast<std::uint64_t>(x / kBlock)};
      if (random.uniform() < 0.5) result(y, x) = wide(y, x);
    }
  return result;
}

// How little there is to match [0..1]: neither texture nor the pattern, which fades with z^2.
cv::Mat_<float> weakness(const Render& exact) {
  constexpr float kPattern = 12;  // contrast at one metre [grey levels]
  constexpr float kEnough = 4;    // [grey levels]
  constexpr int kWindow = 9;      // [px]
  cv::Mat_<float> grey, mean, squares;
  cv::cvtColor(exact.bgr, grey, cv::COLOR_BGR2GRAY);
  cv::boxFilter(grey, mean, CV_32F, {kWindow, kWindow});
  cv::sqrBoxFilter(grey, squares, CV_32F, {kWindow, kWindow});
  cv::Mat_<float> weak(grey.size());
  for (int y = 0; y < weak.rows; ++y)
    for (int x = 0; x < weak.cols; ++x) {
      const float z = exact.depth(y, x);
      const float texture = std::sqrt(std::max(squares(y, x) - mean(y, x) * mean(y, x), 0.0F));
      weak(y, x) = std::clamp(1 - (texture + kPattern / (z * z)) / kEnough, 0.0F, 1.0F);
    }
  return weak;
}

// Blobs whose match is wrong by some pixels; more of them where there is little to match.
void add_speckles(const cv::Mat_<float>& weak, const Shot& shot, cv::Mat_<float>& disparity) {
  constexpr int kCell = 24;                         // one chance each [px]
  constexpr double kUsual = 0.01, kWeakest = 0.15;  // share of the cells
  for (int top = 0; top < weak.rows; top += kCell)
    for (int left = 0; left < weak.cols; left += kCell) {
      Random random{shot.seed, shot.frame, kSpeckleStream, static_cast<std::uint64_t>(top),
                    static_cast<std::uint64_t>(left)};
      const cv::Point centre(std::min(left + random.below(kCell), weak.cols - 1),
                             std::min(top + random.below(kCell), weak.rows - 1));
      const double chance = kUsual + (kWeakest - kUsual) * weak(centre);
      const cv::Size half(2 + random.below(6), 2 + random.below(4));                  // [px]
      const double off = random.uniform(1.5, 6) * (random.uniform() < 0.5 ? -1 : 1);  // [px]
      if (random.uniform() >= chance) continue;
      const double value = disparity(centre) + off;
      cv::ellipse(disparity, centre, half, random.uniform(0, 180), 0, 360, value > 1 ? value : 0,
                  cv::FILLED);
    }
}

}  // namespace

cv::Mat_<float> stereo_depth(const Render& exact, const Shot& shot) {
  constexpr float kSigma = 0.06F, kStep = 1.0F / 32;  // of disparity [px]
  constexpr float kUsualBias = 0.03F, kBias = 0.3F;   // largest deviation, usual and weak [px]
  constexpr int kNoiseRadius = 2, kBiasCell = 48;     // [px]
  constexpr float kHopeless = 0.75F;                  // weakness from which holes appear
  const auto scale = static_cast<float>(shot.focal_length * kBaseline);
  cv::Mat_<float> disparity = widened_disparity(exact_disparity(exact, scale), shot);
  const cv::Mat_<float> weak = weakness(exact);
  cv::Mat_<float> near_wins(disparity.size());
  cv::divide(scale, disparity, near_wins);
  cv::Mat_<float> visible = near_wins.clone();
  drop_shadows(near_wins, visible, shot, kBaseline);
  add_speckles(weak, shot, disparity);
  const cv::Mat_<float> noise = shared_noise(disparity.size(), shot, kNoiseRadius);
  const cv::Mat_<float> bias = smooth_noise(disparity.size(), shot, kBiasCell);
  cv::Mat_<float> depth(disparity.size(), kNoDepth);
  for_each_block(depth.rows, shot.threads, [&](int y) {
    for (int x = 0; x < depth.cols; ++x) {
      const float lost = weak(y, x) - kHopeless + 0.25F * (noise(y, x) - 1);
      if (std::isnan(visible(y, x)) || disparity(y, x) <= 0 || lost > 0) continue;
      const float largest = kUsualBias + (kBias - kUsualBias) * weak(y, x);
      const float value = disparity(y, x) + kSigma * noise(y, x) + largest * bias(y, x);
      const float steps = std::round(value / kStep);
      if (steps >= 1) depth(y, x) = scale / (steps * kStep);
    }
  });
  return depth;
}

}  // namespace edvo::synth
