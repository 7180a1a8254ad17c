// SPDX-License-Identifier: MIT
// Numbers as little-endian bytes, and back.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace edvo {

template <typename T>
void append_number(std::string& bytes, T value) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  static_assert(sizeof(T) == sizeof(Bits));
  const auto bits = std::bit_cast<Bits>(value);
  for (unsigned shift = 0; shift < 8 * sizeof(T); shift += 8)
    bytes.push_back(static_cast<char>(bits >> shift & 0xFF));
}

// Takes numbers off the front of bytes that must outlive it.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  // False for good once there were fewer bytes than asked for; what was read then is 0.
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

  [[nodiscard]] std::string_view bytes(std::size_t size) {
    if (size > rest_.size()) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }

  template <typename T>
  [[nodiscard]] T number() {
    using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
    static_assert(sizeof(T) == sizeof(Bits));
    const std::string_view taken = bytes(sizeof(T));
    Bits bits = 0;
    for (std::size_t i = 0; i < taken.size(); ++i)
      bits |= static_cast<Bits>(static_cast<unsigned char>(taken[i])) << (8 * i);
    return std::bit_cast<T>(bits);
  }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace edvo
