// SPDX-License-Identifier: MIT
// Eight numbers at a time, through the compiler's vector types: the same bits with AVX2, one
// instruction each, and without, two or more (docs/adr/0005).
#pragma once

#include <cstddef>
#include <cstdint>

namespace edvo {

constexpr std::size_t kLanes = 8;

using Floats = float __attribute__((vector_size(32), aligned(4), may_alias));
using Ints = std::int32_t __attribute__((vector_size(32), aligned(4), may_alias));

// Arrays of `count` numbers that are read by lanes have this length, zeros at their end.
[[nodiscard]] constexpr std::size_t padded(std::size_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

// By reference, because how vectors are passed and returned depends on the instruction set.
[[gnu::always_inline]] inline const Floats& lanes(const float* p) {
  return *reinterpret_cast<const Floats*>(p);
}

[[gnu::always_inline]] inline Floats& lanes(float* p) {
  return *reinterpret_cast<Floats*>(p);
}

[[gnu::always_inline]] inline Ints& lanes(std::int32_t* p) {
  return *reinterpret_cast<Ints*>(p);
}

// The sum of eight numbers, always in the same order.
[[gnu::always_inline]] inline float sum_of(const Floats& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

}  // namespace edvo
