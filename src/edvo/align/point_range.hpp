// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/simd/float8.hpp"

#include <cstddef>
#include <vector>

namespace edvo {

// Of points in arrays that are padded: both ends are multiples of simd::kWidth.
struct PointRange {
  std::size_t first = 0, last = 0;
};

[[nodiscard]] inline PointRange all_of(const std::vector<float>& padded) {
  return {0, padded.size()};
}

// One of `count` ranges of about equal size that follow each other, of `size` points.
[[nodiscard]] inline PointRange part_of(std::size_t size, std::size_t index, std::size_t count) {
  const std::size_t lanes = size / simd::kWidth;
  return {lanes * index / count * simd::kWidth, lanes * (index + 1) / count * simd::kWidth};
}

}  // namespace edvo
