// SPDX-License-Identifier: MIT
// Eight numbers at a time, through the vector types that gcc and clang share: the same bits with
// AVX2, one instruction each, and without, two or more (docs/adr/0005).
//
// How a vector of 32 bytes is passed and returned depends on the instruction set, so no function
// here takes or returns one by value: results are members of a struct that a constructor fills.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace edvo::simd {

constexpr std::size_t kWidth = 8;

// Arithmetic, comparisons (-1 where true, 0 elsewhere) and `mask ? a : b` are the compiler's.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));
using Short8 = std::int16_t __attribute__((vector_size(16)));
using Byte8 = std::uint8_t __attribute__((vector_size(8)));

// Arrays of `count` numbers that are read eight at a time have this length, zeros at their end.
[[nodiscard]] constexpr std::size_t padded(std::size_t count) {
  return (count + kWidth - 1) / kWidth * kWidth;
}

template <typename Number>
struct VectorOf;
template <>
struct VectorOf<float> {
  using Type = Float8;
};
template <>
struct VectorOf<std::int32_t> {
  using Type = Int8;
};
template <>
struct VectorOf<std::int16_t> {
  using Type = Short8;
};
template <>
struct VectorOf<std::uint8_t> {
  using Type = Byte8;
};

// Eight numbers in an array, where vectors need not be aligned. An alignment attribute of the
// vector type itself would not do: clang forgets it where a reference is passed on.
template <typename Number>
struct [[gnu::packed, gnu::may_alias]] InArray {
  typename VectorOf<Number>::Type vector;
};

template <typename Number>
struct Load {
  typename VectorOf<Number>::Type value;

  [[gnu::always_inline]] explicit Load(const Number* p)
      : value(reinterpret_cast<const InArray<Number>*>(p)->vector) {}
};

template <typename Number>
[[gnu::always_inline]] inline void store(Number* p, const typename VectorOf<Number>::Type& v) {
  reinterpret_cast<InArray<Number>*>(p)->vector = v;
}

// Each number as another type; floats are cut towards zero, integers to their low bits.
struct ToFloat8 {
  Float8 value;

  [[gnu::always_inline]] explicit ToFloat8(const Int8& v)
      : value(__builtin_convertvector(v, Float8)) {}
};

struct ToInt8 {
  Int8 value;

  [[gnu::always_inline]] explicit ToInt8(const Float8& v)
      : value(__builtin_convertvector(v, Int8)) {}
  [[gnu::always_inline]] explicit ToInt8(const Short8& v)
      : value(__builtin_convertvector(v, Int8)) {}
};

struct ToShort8 {
  Short8 value;

  [[gnu::always_inline]] explicit ToShort8(const Int8& v)
      : value(__builtin_convertvector(v, Short8)) {}
};

struct ToByte8 {
  Byte8 value;

  [[gnu::always_inline]] explicit ToByte8(const Int8& v)
      : value(__builtin_convertvector(v, Byte8)) {}
};

// The numbers of a (0..7) and b (8..15) at these indices.
template <int... kIndices>
requires(sizeof...(kIndices) == kWidth) struct Shuffled {
  Float8 value;

  [[gnu::always_inline]] Shuffled(const Float8& a, const Float8& b)
      : value(__builtin_shufflevector(a, b, kIndices...)) {}
};

struct SquareRoot {
  Float8 value;

  [[gnu::always_inline]] explicit SquareRoot(const Float8& v) {
    float each[kWidth];
    store(each, v);
    for (float& number : each) number = std::sqrt(number);
    value = Load(each).value;
  }
};

// Natural logarithm of positive finite numbers, to 2 parts in 10^7 of it, or of 1 where it is less.
struct Log {
  Float8 value;

  [[gnu::always_inline]] explicit Log(const Float8& v) {
    // v = m 2^e with m between sqrt(1/2) and sqrt(2); log m = 2 artanh((m - 1) / (m + 1)).
    constexpr std::int32_t kExponent = 0x00800000, kRootOfHalf = 0x3f3504f3;
    const Int8 bits = reinterpret_cast<Int8>(v);
    const Int8 exponent = (bits - kRootOfHalf) >> 23;
    const Int8 scaled = bits - exponent * kExponent;
    const Float8 m = reinterpret_cast<Float8>(scaled);
    const Float8 u = (m - 1.F) / (m + 1.F), square = u * u;
    const Float8 series =
        1.F + square * (1.F / 3 + square * (1.F / 5 + square * (1.F / 7 + square * (1.F / 9))));
    value = ToFloat8(exponent).value * 0.693147181F + 2.F * u * series;
  }
};

// The sum of eight numbers, always in the same order.
[[gnu::always_inline]] inline float sum(const Float8& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

// out[i]: the sum of in[i], in the order of sum(); in has eight vectors.
[[gnu::always_inline]] inline void sum_each(const Float8* in, Float8& out) {
  Float8 halves[4], quarters[2];
  for (int i = 0; i < 4; ++i)
    halves[i] = Shuffled<0, 1, 2, 3, 8, 9, 10, 11>(in[i], in[i + 4]).value +
                Shuffled<4, 5, 6, 7, 12, 13, 14, 15>(in[i], in[i + 4]).value;
  for (std::size_t i = 0; i < 2; ++i)
    quarters[i] = Shuffled<0, 1, 8, 9, 4, 5, 12, 13>(halves[2 * i], halves[2 * i + 1]).value +
                  Shuffled<2, 3, 10, 11, 6, 7, 14, 15>(halves[2 * i], halves[2 * i + 1]).value;
  out = Shuffled<0, 2, 8, 10, 4, 6, 12, 14>(quarters[0], quarters[1]).value +
        Shuffled<1, 3, 9, 11, 5, 7, 13, 15>(quarters[0], quarters[1]).value;
}

// out[i][k] = in[k][i], of eight vectors.
[[gnu::always_inline]] inline void transpose(const Float8* in, Float8* out) {
  Float8 a[8], b[8];
  for (int i = 0; i < 8; i += 2) {  // single numbers, then pairs, then halves change places
    a[i] = Shuffled<0, 8, 2, 10, 4, 12, 6, 14>(in[i], in[i + 1]).value;
    a[i + 1] = Shuffled<1, 9, 3, 11, 5, 13, 7, 15>(in[i], in[i + 1]).value;
  }
  for (int i = 0; i < 8; i += 4)
    for (int k = i; k < i + 2; ++k) {
      b[k] = Shuffled<0, 1, 8, 9, 4, 5, 12, 13>(a[k], a[k + 2]).value;
      b[k + 2] = Shuffled<2, 3, 10, 11, 6, 7, 14, 15>(a[k], a[k + 2]).value;
    }
  for (int i = 0; i < 4; ++i) {
    out[i] = Shuffled<0, 1, 2, 3, 8, 9, 10, 11>(b[i], b[i + 4]).value;
    out[i + 4] = Shuffled<4, 5, 6, 7, 12, 13, 14, 15>(b[i], b[i + 4]).value;
  }
}

// Asks the memory for what will be read soon.
[[gnu::always_inline]] inline void prefetch(const void* p) {
  __builtin_prefetch(p);
}

}  // namespace edvo::simd
