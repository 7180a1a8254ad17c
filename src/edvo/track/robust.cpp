// SPDX-License-Identifier: MIT
#include "edvo/track/robust.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace edvo {
namespace {

constexpr std::uint32_t kNoSign = 0x7fffffffU, kInfinity = 0x7f800000U;

// Floats without sign are ordered as their bits are. So the median's bits are found from the first
// to the last, some at a time: how often each value of theirs occurs among those that begin as the
// median does tells which value its rank falls to. Far quicker than to order all.
constexpr std::array<int, 3> kBits = {12, 10, 9};
constexpr std::size_t kMostValues = std::size_t{1} << kBits[0];

}  // namespace

float mad_sigma(std::span<const float> residuals) {
  constexpr float kSigmaPerMad = 1.4826F;  // of a normal distribution
  std::array<std::uint32_t, kMostValues> occurs;
  std::uint32_t median = 0;  // its bits from the first to number `unknown`
  int unknown = 31;
  std::size_t rank = 0;  // among those that begin as the median does
  for (const int bits_now : kBits) {
    const int begun = unknown;
    unknown -= bits_now;
    const std::uint32_t mask = (1U << bits_now) - 1;
    std::fill_n(occurs.begin(), mask + 1, 0U);
    std::size_t count = 0;
    for (const float r : residuals) {
      const std::uint32_t bits = std::bit_cast<std::uint32_t>(r) & kNoSign;
      if (bits > kInfinity || bits >> begun != median) continue;
      ++occurs[bits >> unknown & mask];
      ++count;
    }
    if (count == 0) return 0;
    if (bits_now == kBits[0]) rank = count / 2;
    std::uint32_t value = 0;
    while (rank >= occurs[value]) rank -= occurs[value++];
    median = median << bits_now | value;
  }
  return kSigmaPerMad * std::bit_cast<float>(median);
}

}  // namespace edvo
