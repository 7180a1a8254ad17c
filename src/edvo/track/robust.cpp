// SPDX-License-Identifier: MIT
#include "edvo/track/robust.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

namespace edvo {
namespace {

// Floats without sign are ordered as their bits are: a bin has all those with the same exponent and
// first bits of the mantissa.
constexpr int kBinShift = 19;
constexpr std::uint32_t kNoSign = 0x7fffffffU, kInfinity = 0x7f800000U;
constexpr std::size_t kBins = (kInfinity >> kBinShift) + 1;

}  // namespace

float mad_sigma(std::span<const float> residuals) {
  constexpr float kSigmaPerMad = 1.4826F;  // of a normal distribution
  // Which bin the median is in, then the median of few: far quicker than to order all.
  std::array<std::uint32_t, kBins> bins{};
  std::size_t count = 0;
  for (const float r : residuals) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(r) & kNoSign;
    if (bits > kInfinity) continue;
    ++bins[bits >> kBinShift];
    ++count;
  }
  if (count == 0) return 0;
  std::size_t bin = 0, rank = count / 2;
  while (rank >= bins[bin]) rank -= bins[bin++];
  std::vector<float> near;
  near.reserve(bins[bin]);
  for (const float r : residuals) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(r) & kNoSign;
    if (bits >> kBinShift == bin && bits <= kInfinity) near.push_back(std::bit_cast<float>(bits));
  }
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(near.begin(), middle, near.end());
  return kSigmaPerMad * *middle;
}

}  // namespace edvo
