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

std::vector<SelectedPixel> spread(const std::vector<SelectedPixel>& pixels, int width, int cell,
                                  int limit) {
  const auto wanted = static_cast<std::size_t>(limit);
  if (pixels.size() <= wanted) return pixels;
  const int columns = (width + cell - 1) / cell;
  const auto cell_of = [&](const SelectedPixel& p) {
    return static_cast<std::size_t>(p.pixel.y / cell * columns + p.pixel.x / cell);
  };
  std::vector<std::vector<std::size_t>> cells;  // of pixels
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::size_t c = cell_of(pixels[i]);
    if (c >= cells.size()) cells.resize(c + 1);
    cells[c].push_back(i);
  }
  // So many of each cell, the strongest first, and one more of some.
  const auto taken = [&](std::size_t of_each) {
    std::size_t sum = 0;
    for (const auto& members : cells) sum += std::min(of_each, members.size());
    return sum;
  };
  std::size_t of_each = 0;
  while (taken(of_each + 1) <= wanted) ++of_each;
  const std::size_t left = wanted - taken(of_each), larger = taken(of_each + 1) - taken(of_each);
  const auto stronger = [&](std::size_t a, std::size_t b) {
    return std::pair(-pixels[a].gradient, a) < std::pair(-pixels[b].gradient, b);
  };
  std::vector<std::size_t> kept;
  std::size_t seen = 0;
  for (auto& members : cells) {
    std::size_t count = std::min(of_each, members.size());
    if (members.size() > of_each) {  // every k-th of these: still spread over the image
      count += (seen + 1) * left / larger - seen * left / larger;
      ++seen;
    }
    const auto last = members.begin() + static_cast<std::ptrdiff_t>(count);
    if (count < members.size() && count > 0)
      std::nth_element(members.begin(), last - 1, members.end(), stronger);
    kept.insert(kept.end(), members.begin(), last);
  }
  std::sort(kept.begin(), kept.end());
  std::vector<SelectedPixel> result;
  result.reserve(kept.size());
  for (const std::size_t i : kept) result.push_back(pixels[i]);
  return result;
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
  return spread(pixels, gray.cols, options.cell, options.max_points);
}

std::vector<SelectedPixel> grid_pixels(const Frame& frame, int step, const SelectOptions& options,
                                       std::vector<SelectedPixel> recycled) {
  std::vector<SelectedPixel> pixels = std::move(recycled);
  pixels.clear();
  for (int y = step / 2; y < frame.depth.rows; y += step)
    for (int x = step / 2; x < frame.depth.cols; x += step) {
      const float z = frame.depth(y, x);
      if (z >= static_cast<float>(options.min_depth) && z <= static_cast<float>(options.max_depth))
        pixels.push_back({{x, y}, z, 0.F});
    }
  return pixels;
}

}  // namespace edvo
