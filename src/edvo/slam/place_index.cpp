// SPDX-License-Identifier: MIT
#include "edvo/slam/place_index.hpp"

#include "edvo/core/random.hpp"
#include "edvo/simd/dispatch.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace edvo {
namespace {

constexpr int kWidth = 40, kHeight = 30;  // of the image that ferns look at [px]
constexpr double kBlur = 1.0;             // [px] of it: a small shift changes few tests
constexpr int kTests = 4;                 // per fern, the last one of inverse depth

struct Test {
  std::size_t pixel = 0;    // row-major
  std::uint16_t least = 0;  // rank at which the bit is set, [0..kWidth * kHeight)
};

using Tests = std::array<std::array<Test, kTests>, kFerns>;

Tests make_tests() {
  constexpr std::uint64_t kFernSeed = 0xfe27;
  Random random{kFernSeed};
  Tests tests;
  for (auto& fern : tests)
    for (Test& test : fern) {
      test.pixel = static_cast<std::size_t>(random.below(kWidth * kHeight));
      test.least = static_cast<std::uint16_t>(random.below(kWidth * kHeight));
    }
  return tests;
}

// Mean of the valid inverse depths of each cell [1 / m], 0 where there is none.
cv::Mat_<float> small_inverse_depth(const cv::Mat_<float>& depth) {
  cv::Mat_<float> small(kHeight, kWidth, 0.F);
  for (int cy = 0; cy < kHeight; ++cy)
    for (int cx = 0; cx < kWidth; ++cx) {
      const int top = cy * depth.rows / kHeight, bottom = (cy + 1) * depth.rows / kHeight;
      const int left = cx * depth.cols / kWidth, right = (cx + 1) * depth.cols / kWidth;
      float sum = 0, count = 0;
      for (int y = top; y < bottom; y += 2)
        for (int x = left; x < right; x += 2) {
          const float z = depth(y, x);
          if (!(z > 0)) continue;
          sum += 1.F / z;
          count += 1;
        }
      if (count > 0) small(cy, cx) = sum / count;
    }
  return small;
}

// Each value's place in their order [0..kWidth * kHeight); of equals the earlier pixel first.
std::vector<std::uint16_t> ranks(const cv::Mat_<float>& image) {
  cv::Mat_<float> smooth;
  cv::GaussianBlur(image, smooth, {}, kBlur);
  std::vector<std::uint16_t> order(smooth.total());
  std::iota(order.begin(), order.end(), std::uint16_t{0});
  const float* values = smooth[0];
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint16_t a, std::uint16_t b) { return values[a] < values[b]; });
  std::vector<std::uint16_t> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<std::uint16_t>(i);
  return rank;
}

// Half bytes that are equal.
EDVO_CLONES int equal_ferns(const std::uint8_t* a, const std::uint8_t* b) {
  int equal = 0;
  for (int i = 0; i < kFerns / 2; ++i) {
    const int difference = a[i] ^ b[i];
    equal += ((difference & 0x0f) == 0 ? 1 : 0) + ((difference & 0xf0) == 0 ? 1 : 0);
  }
  return equal;
}

}  // namespace

FernCode make_fern_code(const cv::Mat_<std::uint8_t>& gray, const cv::Mat_<float>& depth) {
  static const Tests kAllTests = make_tests();
  cv::Mat small;
  cv::resize(gray, small, {kWidth, kHeight}, 0, 0, cv::INTER_AREA);
  cv::Mat_<float> small_gray;
  small.convertTo(small_gray, CV_32F);
  const std::vector<std::uint16_t> gray_ranks = ranks(small_gray);
  const std::vector<std::uint16_t> depth_ranks = ranks(small_inverse_depth(depth));
  FernCode code{};
  for (std::size_t fern = 0; fern < kFerns; ++fern) {
    int bits = 0;
    for (std::size_t t = 0; t < kTests; ++t) {
      const Test& test = kAllTests[fern][t];
      const auto& rank = t + 1 < kTests ? gray_ranks : depth_ranks;
      bits = 2 * bits + (rank[test.pixel] >= test.least ? 1 : 0);
    }
    code[fern / 2] = static_cast<std::uint8_t>(code[fern / 2] | bits << (fern % 2 == 0 ? 0 : 4));
  }
  return code;
}

double similarity(const FernCode& a, const FernCode& b) {
  return static_cast<double>(equal_ferns(a.data(), b.data())) / kFerns;
}

void PlaceIndex::add(std::int64_t id, const FernCode& code) {
  ids_.push_back(id);
  codes_.push_back(code);
}

std::vector<PlaceMatch> PlaceIndex::search(const FernCode& code, std::int64_t ids_below,
                                           std::size_t count) const {
  std::vector<PlaceMatch> matches;
  for (std::size_t i = 0; i < ids_.size(); ++i)
    if (ids_[i] < ids_below)
      matches.push_back({.id = ids_[i], .similarity = similarity(code, codes_[i])});
  const auto better = [](const PlaceMatch& a, const PlaceMatch& b) {
    return std::pair(-a.similarity, a.id) < std::pair(-b.similarity, b.id);
  };
  const std::size_t kept = std::min(count, matches.size());
  std::partial_sort(matches.begin(), matches.begin() + static_cast<std::ptrdiff_t>(kept),
                    matches.end(), better);
  matches.resize(kept);
  return matches;
}

}  // namespace edvo
