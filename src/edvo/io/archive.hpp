// SPDX-License-Identifier: MIT
// Archives of sequences, unpacked once into a cache.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

namespace edvo {

inline constexpr std::uintmax_t kLargestCache = 20'000'000'000;  // [bytes]

// A tar or zip archive, plain or compressed (gzip, bzip2, xz, zstd), as a folder in the cache. It
// is unpacked the first time only; the folder's name is made of the archive's name, size and time
// of change. Throws Error(kInput) if it is no archive, damaged, or has links or paths that lead out
// of it; Error(kOutput) if the cache cannot hold it. Either way no partial folder is left.
// on_progress gets the share done [0..1]; an exception that it throws ends the unpacking and is
// passed on. If the cache would grow beyond its limit, the longest unused archives are removed
// (archive_cache.hpp).
[[nodiscard]] std::filesystem::path unpack_archive(
    const std::filesystem::path& archive, const std::filesystem::path& cache,
    const std::function<void(double)>& on_progress = nullptr);

}  // namespace edvo
