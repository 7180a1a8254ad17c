// SPDX-License-Identifier: MIT
// A vector of fixed capacity without heap memory: the subset of C++26's std::inplace_vector that
// edvo uses.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <initializer_list>

namespace edvo {

template <typename T, std::size_t Capacity>
class InplaceVector {
 public:
  InplaceVector() = default;
  InplaceVector(std::initializer_list<T> values) {
    for (const T& value : values) push_back(value);
  }

  void push_back(const T& value) {
    assert(size_ < Capacity);
    values_[size_++] = value;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] T* begin() { return values_.data(); }
  [[nodiscard]] T* end() { return values_.data() + size_; }
  [[nodiscard]] const T* begin() const { return values_.data(); }
  [[nodiscard]] const T* end() const { return values_.data() + size_; }
  [[nodiscard]] T& operator[](std::size_t i) { return values_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return values_[i]; }
  [[nodiscard]] const T& front() const { return values_[0]; }
  [[nodiscard]] const T& back() const { return values_[size_ - 1]; }

 private:
  std::array<T, Capacity> values_{};
  std::size_t size_ = 0;
};

}  // namespace edvo
