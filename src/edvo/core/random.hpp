// SPDX-License-Identifier: MIT
// A counter-based random number generator: the same on every machine, and cheap to seed.
#pragma once

#include <cstdint>
#include <initializer_list>

namespace edvo {

// One well-mixed 64-bit word from another (the finaliser of splitmix64).
[[nodiscard]] constexpr std::uint64_t mix(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9ULL;
  word = (word ^ (word >> 27)) * 0x94d049bb133111ebULL;
  return word ^ (word >> 31);
}

// A stream of random words. Streams of different keys are independent, so rows and frames can be
// made in any order.
class Random {
 public:
  explicit constexpr Random(std::initializer_list<std::uint64_t> keys) {
    for (const std::uint64_t key : keys) state_ = mix(state_ + key + kStep);
  }

  constexpr std::uint64_t word() { return mix(state_ += kStep); }

  constexpr double uniform() { return static_cast<double>(word() >> 11) * 0x1p-53; }  // [0..1)
  constexpr double uniform(double low, double high) { return low + (high - low) * uniform(); }
  constexpr int below(int n) { return static_cast<int>(uniform() * n); }  // [0..n)

  // Mean 0, variance 1: the sum of the word's eight bytes, normal up to 4.9 sigma.
  constexpr float normal() {
    constexpr std::uint64_t kEven = 0x00ff00ff00ff00ffULL;
    const std::uint64_t w = word();
    const std::uint64_t sum = (((w & kEven) + ((w >> 8) & kEven)) * 0x0001000100010001ULL) >> 48;
    constexpr float kMean = 8 * 127.5F;
    constexpr float kSigma = 209.0175F;  // sqrt(8 * (256^2 - 1) / 12)
    return (static_cast<float>(sum) - kMean) / kSigma;
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  std::uint64_t state_ = 0;
};

}  // namespace edvo
