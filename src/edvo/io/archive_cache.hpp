// SPDX-License-Identifier: MIT
// The cache folder of unpacked archives: its contents and its size limit.
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

// The archives that unpack_archive() has put there, longest unused first. Other files are not
// listed. Empty if there is no such folder.
[[nodiscard]] std::vector<CachedArchive> cached_archives(const std::filesystem::path& cache);

// Removes one of them. A program that still reads from it fails at its next image.
void remove_cached(const CachedArchive& archive);

// Removes the longest unused archives until the rest has at most `largest` bytes. Archives used
// within the last day stay.
void limit_cache(const std::filesystem::path& cache, std::uintmax_t largest);

}  // namespace edvo
