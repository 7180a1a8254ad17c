// SPDX-License-Identifier: MIT
// Bytes as a file that needs no disk: readers take paths.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace edvo::fuzz {

class MemoryFile {
 public:
  void write(std::string_view bytes) {
    if (ftruncate(descriptor_, 0) != 0 || lseek(descriptor_, 0, SEEK_SET) != 0) std::abort();
    while (!bytes.empty()) {
      const ssize_t size = ::write(descriptor_, bytes.data(), bytes.size());
      if (size < 0) std::abort();
      bytes.remove_prefix(static_cast<std::size_t>(size));
    }
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  int descriptor_ = memfd_create("fuzz", MFD_CLOEXEC);
  std::string path_ = "/proc/self/fd/" + std::to_string(descriptor_);
};

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// Ends the fuzzing where a property does not hold.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace edvo::fuzz
