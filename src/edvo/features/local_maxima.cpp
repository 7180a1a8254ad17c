// SPDX-License-Identifier: MIT
#include "edvo/features/local_maxima.hpp"

#include "edvo/simd/dispatch.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace edvo {
namespace {

using simd::Float8;
using simd::Int8;

constexpr int kTan22 = 13573;  // tan(22.5 deg) in 1 / 2^15, as cv::Canny rounds it
constexpr std::uint8_t kWeak = 1, kStrong = 2;

[[gnu::always_inline]] inline void widen(const std::int16_t* from, Int8& to) {
  to = simd::ToInt8(simd::Load(from).value).value;
}

[[gnu::always_inline]] inline void magnitude(const Int8& v, Int8& out) {
  out = v < 0 ? -v : v;
}

EDVO_CLONES void add_up(const std::int16_t* gx, const std::int16_t* gy, int count,
                        std::int16_t* norm) {
  for (int i = 0; i < count; i += static_cast<int>(simd::kWidth)) {
    Int8 x, y;
    widen(gx + i, x);
    widen(gy + i, y);
    magnitude(x, x);
    magnitude(y, y);
    simd::store(norm + i, simd::ToShort8(x + y).value);
  }
}

EDVO_CLONES void weigh(const float* weights, float unit, int count, std::int16_t* gradient) {
  for (int i = 0; i < count; i += static_cast<int>(simd::kWidth)) {
    Int8 g;
    widen(gradient + i, g);
    const Float8 weighed = unit * simd::Load(weights + i).value * simd::ToFloat8(g).value;
    const Float8 half = weighed < 0.F ? Float8{} - 0.5F : Float8{} + 0.5F;
    simd::store(gradient + i, simd::ToShort8(simd::ToInt8(weighed + half).value).value);
  }
}

// 0, kWeak or kStrong for a row of `count` pixels. Of two equal neighbours along a row or column
// the first is the maximum.
EDVO_CLONES void classify(const std::int16_t* gx, const std::int16_t* gy, const std::int16_t* above,
                          const std::int16_t* row, const std::int16_t* below, int count, int low,
                          int high, std::uint8_t* classes) {
  for (int i = 0; i < count; i += static_cast<int>(simd::kWidth)) {
    Int8 x, y, norm, left, right, up, down, up_left, up_right, down_left, down_right;
    widen(gx + i, x);
    widen(gy + i, y);
    widen(row + i, norm);
    widen(row + i - 1, left);
    widen(row + i + 1, right);
    widen(above + i, up);
    widen(below + i, down);
    widen(above + i - 1, up_left);
    widen(above + i + 1, up_right);
    widen(below + i - 1, down_left);
    widen(below + i + 1, down_right);
    const Int8 rising = (x ^ y) < 0;
    magnitude(x, x);
    magnitude(y, y);
    const Int8 tan22 = x * kTan22, scaled = y << 15;
    const Int8 horizontal = scaled<tan22, vertical = scaled> tan22 + (x << 16);
    const Int8 straight = horizontal | vertical;
    const Int8 before = horizontal ? left : vertical ? up : rising ? up_right : up_left;
    const Int8 after = horizontal ? right : vertical ? down : rising ? down_left : down_right;
    const Int8 weak = (norm > before) & (norm > after + straight) & (norm > low);
    const Int8 strong = weak & (norm > high);
    simd::store(classes + i, simd::ToByte8(-(weak + strong)).value);
  }
}

// Makes the weak pixels that touch strong ones strong, and so on. The outermost pixels are 0.
void spread_strong(cv::Mat_<std::uint8_t>& classes) {
  std::vector<std::uint8_t*> open;
  for (int y = 1; y + 1 < classes.rows; ++y) {
    std::uint8_t* const row = classes[y];
    std::uint8_t* const end = row + classes.cols;
    for (void* at = row;
         (at = std::memchr(at, kStrong,
                           static_cast<std::size_t>(end - static_cast<std::uint8_t*>(at))));
         at = static_cast<std::uint8_t*>(at) + 1)
      open.push_back(static_cast<std::uint8_t*>(at));
  }
  const auto stride = static_cast<std::ptrdiff_t>(classes.step[0]);
  while (!open.empty()) {
    std::uint8_t* const pixel = open.back();
    open.pop_back();
    for (std::uint8_t* row = pixel - stride - 1; row <= pixel + stride - 1; row += stride) {
      const bool any = ((row[0] | row[1] | row[2]) & kWeak) != 0;
      if (!any) continue;
      for (std::uint8_t* at = row; at < row + 3; ++at)
        if (*at == kWeak) {
          *at = kStrong;
          open.push_back(at);
        }
    }
  }
}

}  // namespace

GradientImage sobel_gradients(const cv::Mat_<std::uint8_t>& image, const cv::Mat_<float>& weights,
                              int unit) {
  const int width = static_cast<int>(simd::padded(static_cast<std::size_t>(image.cols)));
  GradientImage result{.size = image.size(),
                       .x = cv::Mat_<std::int16_t>(image.rows, width, std::int16_t{0}),
                       .y = cv::Mat_<std::int16_t>(image.rows, width, std::int16_t{0}),
                       .norm = cv::Mat_<std::int16_t>(image.rows + 2, width + 2, std::int16_t{0})};
  const cv::Range columns(0, image.cols);
  cv::Sobel(image, result.x.colRange(columns), CV_16S, 1, 0);
  cv::Sobel(image, result.y.colRange(columns), CV_16S, 0, 1);
  std::vector<float> weight(static_cast<std::size_t>(width));
  for (int y = 0; y < image.rows; ++y) {
    if (!weights.empty()) {
      std::copy_n(weights[y], image.cols, weight.begin());
      weigh(weight.data(), static_cast<float>(unit), width, result.x[y]);
      weigh(weight.data(), static_cast<float>(unit), width, result.y[y]);
    }
    add_up(result.x[y], result.y[y], width, result.norm[y + 1] + 1);
  }
  return result;
}

int norm_quantile(const GradientImage& gradients, double share) {
  constexpr int kHighest = 8 * 2 * 4 * 255;  // the largest unit, two directions, Sobel's weights
  // In turn into two: neighbours are often equal, and a counter has to wait for itself.
  std::vector<int> histogram(2 * (kHighest + 1));
  int* const other = histogram.data() + kHighest + 1;
  const cv::Size size = gradients.size;
  for (int y = 1; y <= size.height; ++y) {
    const std::int16_t* norm = gradients.norm[y] + 1;
    int x = 0;
    for (; x + 1 < size.width; x += 2) {
      ++histogram[static_cast<std::size_t>(norm[x])];
      ++other[norm[x + 1]];
    }
    if (x < size.width) ++other[norm[x]];
  }
  const double wanted = share * static_cast<double>(size.area());
  double above = 0;
  int norm = kHighest;
  while (norm > 0 && (above += histogram[static_cast<std::size_t>(norm)] + other[norm]) < wanted)
    --norm;
  return norm;
}

cv::Mat_<std::uint8_t> connected_maxima(const GradientImage& gradients, int low, int high) {
  const cv::Size size = gradients.size;
  const int width = gradients.x.cols;
  cv::Mat_<std::uint8_t> classes(size.height + 2, width + 2, std::uint8_t{0});
  for (int y = 0; y < size.height; ++y)
    classify(gradients.x[y], gradients.y[y], gradients.norm[y] + 1, gradients.norm[y + 1] + 1,
             gradients.norm[y + 2] + 1, width, low, high, classes[y + 1] + 1);
  spread_strong(classes);
  cv::Mat_<std::uint8_t> edges;
  cv::compare(classes(cv::Rect({1, 1}, size)), kStrong, edges, cv::CMP_EQ);
  return edges;
}

}  // namespace edvo
