// SPDX-License-Identifier: MIT
#include "edvo/align/robust.hpp"

#include <array>
#include <bit>
#include <cstdint>

namespace edvo {
namespace {

constexpr std::uint32_t kNoSign = 0x7fffffffU, kInfinity = 0x7f800000U;

// Floats without sign are ordered as their bits are. So the median's bits are found from the first
// on, some at a time: how often each value of theirs occurs among those that begin as the median
// does tells which value its rank falls to. Far quicker than to order all.
constexpr int kFirstBits = 12, kNextBits = 10;
constexpr int kAfterFirst = 31 - kFirstBits, kAfterNext = kAfterFirst - kNextBits;

// The bits of a number without its sign; those of NaN behind all others.
std::uint32_t size_bits(float r) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(r) & kNoSign;
  return bits > kInfinity ? kNoSign : bits;
}

// The value that a rank falls to, by how often each occurs; of the rank, what is left in it.
std::uint32_t value_at(std::span<const std::uint32_t> occurs, std::size_t& rank) {
  std::uint32_t value = 0;
  while (rank >= occurs[value]) rank -= occurs[value++];
  return value;
}

}  // namespace

float mad_sigma(std::span<const float> residuals) {
  constexpr float kSigmaPerMad = 1.4826F;  // of a normal distribution
  std::array<std::uint32_t, 1 << kFirstBits> first{};
  for (const float r : residuals) ++first[size_bits(r) >> kAfterFirst];
  const std::size_t count = residuals.size() - first.back();
  if (count == 0) return 0;
  std::size_t rank = count / 2;
  const std::uint32_t begin = value_at(first, rank);
  std::array<std::uint32_t, 1 << kNextBits> next{};
  for (const float r : residuals) {
    const std::uint32_t bits = size_bits(r);
    if (bits >> kAfterFirst == begin) ++next[bits >> kAfterNext & (next.size() - 1)];
  }
  const std::uint32_t bits = begin << kNextBits | value_at(next, rank);
  return kSigmaPerMad * std::bit_cast<float>(bits << kAfterNext);
}

}  // namespace edvo
