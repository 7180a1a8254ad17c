// SPDX-License-Identifier: MIT
#include "edvo/track/selection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr int kBorder = 4;  // [px] room for gradients and patches

float gradient_magnitude(const cv::Mat_<std::uint8_t>& gray, int x, int y) {
  const float gx = 0.5F * static_cast<float>(gray(y, x + 1) - gray(y, x - 1));
  const float gy = 0.5F * static_cast<float>(gray(y + 1, x) - gray(y - 1, x));
  return std::sqrt(gx * gx + gy * gy);
}

}  // namespace

std::vector<SelectedPixel> spread(std::vector<SelectedPixel> pixels, int width, int cell,
                                  int limit) {
  const int columns = (width + cell - 1) / cell;
  if (static_cast<int>(pixels.size()) <= limit) return pixels;
  const auto cell_of = [&](const SelectedPixel& p) {
    return p.pixel.y / cell * columns + p.pixel.x / cell;
  };
  std::stable_sort(pixels.begin(), pixels.end(),
                   [&](const SelectedPixel& a, const SelectedPixel& b) {
                     return std::pair(cell_of(a), -a.gradient) < std::pair(cell_of(b), -b.gradient);
                   });
  std::vector<int> count_of_rank;
  std::vector<int> ranks(pixels.size(), 0);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    ranks[i] = i > 0 && cell_of(pixels[i]) == cell_of(pixels[i - 1]) ? ranks[i - 1] + 1 : 0;
    count_of_rank.resize(std::max<std::size_t>(count_of_rank.size(), ranks[i] + 1));
    ++count_of_rank[static_cast<std::size_t>(ranks[i])];
  }
  int last_whole_rank = -1, taken = 0;
  while (taken + count_of_rank[static_cast<std::size_t>(last_whole_rank + 1)] <= limit)
    taken += count_of_rank[static_cast<std::size_t>(++last_whole_rank)];
  // Of the rank that does not fit whole, every k-th cell: still spread over the image.
  const int partial = count_of_rank[static_cast<std::size_t>(last_whole_rank + 1)];
  const int wanted = limit - taken;
  std::vector<SelectedPixel> kept;
  int seen = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (ranks[i] <= last_whole_rank) kept.push_back(pixels[i]);
    if (ranks[i] != last_whole_rank + 1) continue;
    if (static_cast<std::int64_t>(seen + 1) * wanted / partial >
        static_cast<std::int64_t>(seen) * wanted / partial)
      kept.push_back(pixels[i]);
    ++seen;
  }
  std::sort(kept.begin(), kept.end(), [](const SelectedPixel& a, const SelectedPixel& b) {
    return std::pair(a.pixel.y, a.pixel.x) < std::pair(b.pixel.y, b.pixel.x);
  });
  return kept;
}

float edge_depth(const cv::Mat_<float>& depth, cv::Point pixel, const SelectOptions& options) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const float centre = depth(pixel);
  float nearest = std::numeric_limits<float>::infinity(), farthest = 0;
  const int r = options.jump_radius;
  for (int y = pixel.y - r; y <= pixel.y + r; ++y)
    for (int x = pixel.x - r; x <= pixel.x + r; ++x) {
      const float z = depth(y, x);
      if (std::isnan(z)) continue;
      nearest = std::min(nearest, z);
      farthest = std::max(farthest, z);
    }
  const bool jump = farthest - nearest > static_cast<float>(options.jump) * nearest;
  const float chosen = jump ? (options.foreground ? nearest : kNone) : centre;
  const bool trusted = chosen >= static_cast<float>(options.min_depth) &&
                       chosen <= static_cast<float>(options.max_depth);
  return trusted ? chosen : kNone;
}

std::vector<SelectedPixel> select_pixels(const Frame& frame, const cv::Mat_<std::uint8_t>& mask,
                                         const cv::Mat_<std::uint8_t>& valid,
                                         const SelectOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  const int border = std::max(kBorder, options.jump_radius);
  std::vector<SelectedPixel> pixels;
  for (int y = border; y < gray.rows - border; ++y) {
    const std::uint8_t* candidates = mask[y];
    for (int x = border; x < gray.cols - border; ++x) {
      if (candidates[x] == 0 || valid(y, x) == 0) continue;
      const float gradient = gradient_magnitude(gray, x, y);
      if (gradient < static_cast<float>(options.min_gradient)) continue;
      const float depth = edge_depth(frame.depth, {x, y}, options);
      if (!std::isnan(depth)) pixels.push_back({{x, y}, depth, gradient});
    }
  }
  return spread(std::move(pixels), gray.cols, options.cell, options.max_points);
}

std::vector<SelectedPixel> grid_pixels(const Frame& frame, int step, const SelectOptions& options) {
  std::vector<SelectedPixel> pixels;
  for (int y = step / 2; y < frame.depth.rows; y += step)
    for (int x = step / 2; x < frame.depth.cols; x += step) {
      const float z = frame.depth(y, x);
      if (z >= static_cast<float>(options.min_depth) && z <= static_cast<float>(options.max_depth))
        pixels.push_back({{x, y}, z, 0.F});
    }
  return pixels;
}

}  // namespace edvo
