// SPDX-License-Identifier: MIT
// Keeps two programs from writing the same map.
#pragma once

#include <filesystem>

namespace edvo {

// Holds the lock of a map file while it lives: a file beside it, named <map>.lock, which goes with
// it. A program that ends in any way loses its locks. Reading a map needs none: a file that is
// replaced is replaced whole.
class MapLock {
 public:
  // Throws Error(kMap) if another program has it, Error(kOutput) if there can be none.
  explicit MapLock(const std::filesystem::path& map);
  ~MapLock();
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace edvo
