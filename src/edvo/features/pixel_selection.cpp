// SPDX-License-Identifier: MIT
#include "edvo/features/pixel_selection.hpp"

#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

constexpr int kBorder = 4;  // [px] room for gradients and patches
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// Of the pixel at p, in an image of this stride.
float gradient_magnitude(const std::uint8_t* p, std::ptrdiff_t stride) {
  const float gx = 0.5F * static_cast<float>(p[1] - p[-1]);
  const float gy = 0.5F * static_cast<float>(p[stride] - p[-stride]);
  return std::sqrt(gx * gx + gy * gy);
}

struct DepthLimits {
  float jump, min, max;
  bool foreground;
};

// The nearest and the farthest depth of each column of some rows; infinity and 0 where there is
// none. width: at least simd::kWidth, as below.
EDVO_CLONES void span_columns(const float* const* rows, std::size_t count, std::size_t width,
                              float* nearest, float* farthest) {
  for (std::size_t begin = 0; begin < width; begin += simd::kWidth) {
    const std::size_t x = std::min(begin, width - simd::kWidth);
    Float8 low = Float8{} + std::numeric_limits<float>::infinity(), high{};
    for (std::size_t i = 0; i < count; ++i) {
      const Float8& z = simd::load(rows[i] + x);  // NaN is neither nearer nor farther
      low = z < low ? z : low;
      high = z > high ? z : high;
    }
    simd::store(nearest + x, low);
    simd::store(farthest + x, high);
  }
}

// Each pixel's own depth or, at a jump, the nearest one, from the spans of `count` columns around,
// the first of which is at nearest and farthest.
EDVO_CLONES void choose_depths(const float* nearest, const float* farthest, std::size_t count,
                               const float* centre, std::size_t width, const DepthLimits& limits,
                               float* depths) {
  const Float8 none = Float8{} + kNone;
  for (std::size_t begin = 0; begin < width; begin += simd::kWidth) {
    const std::size_t x = std::min(begin, width - simd::kWidth);
    Float8 low = simd::load(nearest + x), high = simd::load(farthest + x);
    for (std::size_t k = 1; k < count; ++k) {
      const Float8 &near = simd::load(nearest + x + k), &far = simd::load(farthest + x + k);
      low = near < low ? near : low;
      high = far > high ? far : high;
    }
    const Float8 at_jump = limits.foreground ? low : none;
    const Float8 chosen = high - low > limits.jump * low ? at_jump : simd::load(centre + x);
    const Int8 trusted = (chosen >= limits.min) & (chosen <= limits.max);
    simd::store(depths + x, trusted ? chosen : none);
  }
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

void edge_depths(const cv::Mat_<float>& depth, int y, const SelectOptions& options,
                 std::vector<float>& depths) {
  const auto width = static_cast<std::size_t>(depth.cols);
  const auto radius = static_cast<std::size_t>(options.jump_radius);
  std::vector<const float*> rows;
  for (int i = y - options.jump_radius; i <= y + options.jump_radius; ++i) rows.push_back(depth[i]);
  // Beyond the left and right border there is no depth.
  std::vector<float> nearest(width + 2 * radius, std::numeric_limits<float>::infinity());
  std::vector<float> farthest(width + 2 * radius, 0.F);
  span_columns(rows.data(), rows.size(), width, nearest.data() + radius, farthest.data() + radius);
  depths.resize(width);
  choose_depths(nearest.data(), farthest.data(), 2 * radius + 1, depth[y], width,
                {.jump = static_cast<float>(options.jump),
                 .min = static_cast<float>(options.min_depth),
                 .max = static_cast<float>(options.max_depth),
                 .foreground = options.foreground},
                depths.data());
}

std::vector<SelectedPixel> select_pixels(const Frame& frame, const cv::Mat_<std::uint8_t>& mask,
                                         const cv::Mat_<std::uint8_t>& valid,
                                         const SelectOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  const int border = std::max(kBorder, options.jump_radius);
  const cv::Mat_<float> depth = frame.depth.undistorted();
  const auto stride = static_cast<std::ptrdiff_t>(gray.step[0]);
  const auto least = static_cast<float>(options.min_gradient);
  std::vector<SelectedPixel> pixels;
  std::vector<float> depths;
  for (int y = border; y < gray.rows - border; ++y) {
    const std::uint8_t *candidates = mask[y], *seen = valid[y], *row = gray[y];
    if (std::all_of(candidates, candidates + mask.cols, [](std::uint8_t c) { return c == 0; }))
      continue;
    edge_depths(depth, y, options, depths);
    for (int x = border; x < gray.cols - border; ++x) {
      if (candidates[x] == 0 || seen[x] == 0) continue;
      const float gradient = gradient_magnitude(row + x, stride);
      if (gradient < least) continue;
      const float z = depths[static_cast<std::size_t>(x)];
      if (!std::isnan(z)) pixels.push_back({{x, y}, z, gradient});
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
      if (z >= static_cast<float>(options.min_depth) && z <= static_cast<float>(options.max_depth))
        pixels.push_back({{x, y}, z, 0.F});
    }
  return pixels;
}

}  // namespace edvo
