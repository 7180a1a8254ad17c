// SPDX-License-Identifier: MIT
// The folder that keeps unpacked archives: what is in it, and how it stays small.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace edvo {

struct CachedArchive {
  std::filesystem::path folder;
  std::uintmax_t bytes = 0;  // on disk, about
  std::filesystem::file_time_type used;
};

// What unpack_archive() has left there, the longest unused first. Other files are not listed. No
// folder, no archives.
[[nodiscard]] std::vector<CachedArchive> cached_archives(const std::filesystem::path& cache);

// Removes one of them. A program that reads from it fails at its next image.
void remove_cached(const CachedArchive& archive);

// Removes the longest unused until the rest is at most so large. Those used within a day stay.
void limit_cache(const std::filesystem::path& cache, std::uintmax_t largest);

}  // namespace edvo
