// SPDX-License-Identifier: MIT
#include "edvo/features/pixel_selection.hpp"

#include "edvo/features/edge_depth.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace edvo {
namespace {

constexpr int kBorder = 4;  // [px] room for gradients and patches
static_assert(kBorder > kEdgeDepthRadius);

// Of the pixel at p, in an image of this stride.
float gradient_magnitude(const std::uint8_t* p, std::ptrdiff_t stride) {
  const float gx = 0.5F * static_cast<float>(p[1] - p[-1]);
  const float gy = 0.5F * static_cast<float>(p[stride] - p[-stride]);
  return std::sqrt(gx * gx + gy * gy);
}

// Not NaN, and in the range of the sensor.
bool is_trusted(float depth, const SelectOptions& options) {
  return depth >= static_cast<float>(options.min_depth) &&
         depth <= static_cast<float>(options.max_depth);
}

}  // namespace

std::vector<SelectedPixel> spread(const std::vector<SelectedPixel>& pixels, int width, int cell,
                                  int limit) {
  const auto wanted = static_cast<std::size_t>(limit);
  if (pixels.size() <= wanted) return pixels;
  const int columns = (width + cell - 1) / cell;
  std::vector<int> column_of(static_cast<std::size_t>(width));  // quicker than to divide
  for (int x = 0; x < width; ++x) column_of[static_cast<std::size_t>(x)] = x / cell;
  std::vector<std::uint32_t> cells;  // of each pixel
  cells.reserve(pixels.size());
  std::size_t count = 0;
  for (int y = -1, first = 0; const SelectedPixel& p : pixels) {
    if (p.pixel.y != y) first = (y = p.pixel.y) / cell * columns;
    cells.push_back(
        static_cast<std::uint32_t>(first + column_of[static_cast<std::size_t>(p.pixel.x)]));
    count = std::max<std::size_t>(count, cells.back() + 1);
  }
  std::vector<std::uint32_t> ends(count + 1);  // of each cell's members, first where they begin
  for (const std::uint32_t c : cells) ++ends[c + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<std::uint32_t> members(pixels.size());
  for (std::uint32_t i = 0; i < pixels.size(); ++i) members[ends[cells[i]]++] = i;
  const auto size = [&](std::size_t c) -> std::size_t {
    return ends[c] - (c > 0 ? ends[c - 1] : 0);
  };
  // So many of each cell, the strongest first, and one more of some.
  const auto taken = [&](std::size_t of_each) {
    std::size_t sum = 0;
    for (std::size_t c = 0; c < count; ++c) sum += std::min(of_each, size(c));
    return sum;
  };
  std::size_t of_each = 0;
  while (taken(of_each + 1) <= wanted) ++of_each;
  const std::size_t left = wanted - taken(of_each), larger = taken(of_each + 1) - taken(of_each);
  const auto stronger = [&](std::uint32_t a, std::uint32_t b) {
    const float ga = pixels[a].gradient, gb = pixels[b].gradient;
    return ga > gb || (ga == gb && a < b);
  };
  std::vector<std::uint8_t> kept(pixels.size());
  std::size_t seen = 0;
  for (std::size_t c = 0; c < count; ++c) {
    std::size_t best = std::min(of_each, size(c));
    if (size(c) > of_each) {  // every k-th of these: still spread over the image
      best += (seen + 1) * left / larger - seen * left / larger;
      ++seen;
    }
    const auto last = members.begin() + static_cast<std::ptrdiff_t>(ends[c]);
    const auto first = last - static_cast<std::ptrdiff_t>(size(c));
    const auto middle = first + static_cast<std::ptrdiff_t>(best);
    if (best < size(c) && best > 0) std::nth_element(first, middle - 1, last, stronger);
    for (auto member = first; member != middle; ++member) kept[*member] = 1;
  }
  std::vector<SelectedPixel> result;
  result.reserve(wanted);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (kept[i] != 0) result.push_back(pixels[i]);
  return result;
}

std::vector<SelectedPixel> select_pixels(const Frame& frame, const cv::Mat_<std::uint8_t>& mask,
                                         const cv::Mat_<std::uint8_t>& valid,
                                         const SelectOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  const cv::Mat_<float> depth = frame.depth.undistorted();
  const auto stride = static_cast<std::ptrdiff_t>(gray.step[0]);
  const auto least = static_cast<float>(options.min_gradient);
  std::vector<SelectedPixel> pixels;
  for (int y = kBorder; y < gray.rows - kBorder; ++y) {
    const std::uint8_t *candidates = mask[y], *seen = valid[y], *row = gray[y];
    if (std::all_of(candidates, candidates + mask.cols, [](std::uint8_t c) { return c == 0; }))
      continue;
    for (int x = kBorder; x < gray.cols - kBorder; ++x) {
      if (candidates[x] == 0 || seen[x] == 0) continue;
      const float gradient = gradient_magnitude(row + x, stride);
      if (gradient < least) continue;
      const float z = edge_depth(depth, {x, y});
      if (is_trusted(z, options)) pixels.push_back({{x, y}, z, gradient});
    }
  }
  return spread(pixels, gray.cols, options.cell, options.max_points);
}

std::vector<SelectedPixel> grid_pixels(const Frame& frame, int step, const SelectOptions& options,
                                       std::vector<SelectedPixel> recycled) {
  std::vector<SelectedPixel> pixels = std::move(recycled);
  pixels.clear();
  for (int y = step / 2; y < frame.depth.rows(); y += step)
    for (int x = step / 2; x < frame.depth.cols(); x += step) {
      const float z = frame.depth(y, x);
      if (is_trusted(z, options)) pixels.push_back({{x, y}, z, 0.F});
    }
  return pixels;
}

}  // namespace edvo
