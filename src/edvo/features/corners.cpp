// SPDX-License-Identifier: MIT
#include "edvo/features/corners.hpp"

#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

using simd::Float8;

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

// As many numbers as stay in registers while a kernel passes over them.
constexpr int kStrip = 2 * static_cast<int>(simd::kWidth);

// Squares and product of Sobel's gradient, from three rows of count + 2 pixels.
EDVO_CLONES void gradient_products(const float* above, const float* row, const float* below,
                                   int count, float* __restrict xx, float* __restrict xy,
                                   float* __restrict yy) {
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

// The weighted sum of rows[0..2 radius], rows[radius] the middle one. half_kernel: its centre
// first. count: a multiple of kStrip.
EDVO_CLONES void weighted_sum(const float* const* rows, const float* half_kernel, int radius,
                              int count, float* out) {
  for (int x = 0; x < count; x += kStrip) {
    const float* middle = rows[radius] + x;
    Float8 a = half_kernel[0] * simd::Load(middle).value,
           b = half_kernel[0] * simd::Load(middle + simd::kWidth).value;
    for (int i = 1; i <= radius; ++i) {
      const float *before = rows[radius - i] + x, *after = rows[radius + i] + x;
      a += half_kernel[i] * (simd::Load(before).value + simd::Load(after).value);
      b += half_kernel[i] *
           (simd::Load(before + simd::kWidth).value + simd::Load(after + simd::kWidth).value);
    }
    simd::store(out + x, a);
    simd::store(out + x + simd::kWidth, b);
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

// Row of an image with `border` more pixels on each side, [0..1].
void wide_row(const cv::Mat_<std::uint8_t>& image, int y, int border, float* out) {
  constexpr float kScale = 1.F / 255;
  const std::uint8_t* row = image[cv::borderInterpolate(y, image.rows, cv::BORDER_REFLECT_101)];
  for (int x = 0; x < image.cols; ++x) out[border + x] = kScale * static_cast<float>(row[x]);
  for (int x = -border; x < 0; ++x) {
    const int right = image.cols - 1 - x;
    out[border + x] = out[border + cv::borderInterpolate(x, image.cols, cv::BORDER_REFLECT_101)];
    out[border + right] =
        out[border + cv::borderInterpolate(right, image.cols, cv::BORDER_REFLECT_101)];
  }
}

// The largest of them and `least`.
EDVO_CLONES float largest(const float* values, std::size_t count, float least) {
  Float8 most = Float8{} + least;
  std::size_t i = 0;
  for (; i + simd::kWidth <= count; i += simd::kWidth) {
    const Float8 v = simd::Load(values + i).value;
    most = v > most ? v : most;
  }
  for (; i < count; ++i) least = std::max(least, values[i]);
  for (std::size_t k = 0; k < simd::kWidth; ++k) least = std::max(least, most[k]);
  return least;
}

// Writes the response of each row from the top to row_of(y) and calls visit(y). Row by row, so that
// everything between the image and the response stays in the cache.
template <typename RowOf, typename Visitor>
void for_each_response_row(const cv::Mat_<std::uint8_t>& image, double window_sigma, RowOf&& row_of,
                           Visitor&& visit) {
  const std::vector<float> kernel = gaussian(window_sigma);
  const int radius = static_cast<int>(kernel.size()) - 1;
  const int length = 2 * radius + 1;
  const int border = radius + 1;  // one more for the differences
  const int columns = (image.cols + kStrip - 1) / kStrip * kStrip;
  cv::Mat_<float> pixels(3, image.cols + 2 * border);  // rings of rows
  cv::Mat_<float> products(3, columns + 2 * radius, 0.F), blurred(3 * length, columns);
  cv::Mat_<float> sums(3, columns);  // of xx, xy and yy over the window
  std::vector<const float*> rows(static_cast<std::size_t>(length));
  for (int i = 0; i < image.rows + 2 * border; ++i) {
    wide_row(image, i - border, border, pixels[i % 3]);
    const int y = i - 2;  // of the products, counted from the first
    if (y < 0) continue;
    gradient_products(pixels[y % 3], pixels[(y + 1) % 3], pixels[(y + 2) % 3],
                      image.cols + 2 * radius, products[0], products[1], products[2]);
    for (int p = 0; p < 3; ++p) {
      for (int k = 0; k < length; ++k) rows[static_cast<std::size_t>(k)] = products[p] + k;
      weighted_sum(rows.data(), kernel.data(), radius, columns, blurred[p * length + y % length]);
    }
    if (y < 2 * radius) continue;
    for (int p = 0; p < 3; ++p) {
      for (int k = 0; k < length; ++k)
        rows[static_cast<std::size_t>(k)] = blurred[p * length + (y - 2 * radius + k) % length];
      weighted_sum(rows.data(), kernel.data(), radius, columns, sums[p]);
    }
    smaller_eigenvalue(sums[0], sums[1], sums[2], image.cols, row_of(y - 2 * radius));
    visit(y - 2 * radius);
  }
}

// 1 where a response is positive and the largest of its 3x3 neighbourhood. Of equal neighbours the
// first in row order wins, so that a plateau gives one corner.
EDVO_CLONES void mark_maxima(const float* above, const float* row, const float* below, int count,
                             std::uint8_t* __restrict marks) {
  for (int x = 1; x + 1 < count; ++x) {
    const float r = row[x];
    const bool first = (r > above[x - 1]) & (r > above[x]) & (r > above[x + 1]) & (r > row[x - 1]);
    const bool largest =
        (r >= row[x + 1]) & (r >= below[x - 1]) & (r >= below[x]) & (r >= below[x + 1]);
    marks[x] = (r > 0.F) & first & largest;
  }
}

// In row order, above the given share of the strongest response.
std::vector<Corner> local_maxima(const cv::Mat_<std::uint8_t>& image,
                                 const CornerOptions& options) {
  const auto width = static_cast<std::size_t>(image.cols);
  std::vector<Corner> corners;
  float strongest = 0;
  cv::Mat_<float> ring(3, image.cols);
  std::vector<std::uint8_t> marks(width);
  const auto row_of = [&](int y) { return ring[y % 3]; };
  for_each_response_row(image, options.window_sigma, row_of, [&](int y) {
    strongest = largest(ring[y % 3], width, strongest);
    if (y < 2) return;
    const float* row = ring[(y - 1) % 3];
    mark_maxima(ring[(y - 2) % 3], row, ring[y % 3], image.cols, marks.data());
    for (auto mark = marks.begin(); (mark = std::find(mark, marks.end(), 1)) != marks.end();
         ++mark) {
      const int x = static_cast<int>(mark - marks.begin());
      corners.push_back({{x, y - 1}, row[x]});
    }
  });
  const auto threshold = static_cast<float>(options.quality * static_cast<double>(strongest));
  std::erase_if(corners, [&](const Corner& corner) { return corner.response <= threshold; });
  return corners;
}

}  // namespace

cv::Mat_<float> min_eigenvalue(const cv::Mat_<std::uint8_t>& image, double window_sigma) {
  cv::Mat_<float> response(image.size());
  for_each_response_row(
      image, window_sigma, [&](int y) { return response[y]; }, [](int) {});
  return response;
}

std::vector<Corner> optimize_corners(const cv::Mat_<std::uint8_t>& edges,
                                     const CornerOptions& options) {
  const std::vector<Corner> all = local_maxima(edges, options);
  const int columns = (edges.cols + options.window - 1) / options.window;
  const int rows = (edges.rows + options.window - 1) / options.window;
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

cv::Mat_<std::uint8_t> with_corner_discs(const cv::Mat_<std::uint8_t>& edges,
                                         const CornerOptions& options) {
  if (!options.enabled) return edges;
  cv::Mat_<std::uint8_t> mask =
      draw_discs(edges.size(), optimize_corners(edges, options), options.disc_radius);
  mask |= edges;
  return mask;
}

}  // namespace edvo
