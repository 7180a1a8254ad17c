// SPDX-License-Identifier: MIT
#include "edvo/io/archive_cache.hpp"

#include <algorithm>
#include <chrono>
#include <regex>
#include <string>

namespace edvo {
namespace {

namespace fs = std::filesystem;

// Each file takes whole blocks and an entry of its own, also an empty one.
std::uintmax_t bytes_in(const fs::path& folder) {
  constexpr std::uintmax_t kBlock = 4096;
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    const bool is_file = entry->is_regular_file(ignored);
    const std::uintmax_t size = is_file ? entry->file_size(ignored) : 0;
    bytes += (size / kBlock + 2) * kBlock;
  }
  return bytes;
}

// As unpack_archive() names them: NAME-SIZE-TIME, or .partial if it was killed.
bool is_cached_archive(const fs::path& folder) {
  static const std::regex kName("[^]+-[0-9a-f]+-[0-9a-f]+(\\.partial)?");
  std::error_code ignored;
  return fs::is_directory(fs::symlink_status(folder, ignored)) &&
         std::regex_match(folder.filename().string(), kName);
}

}  // namespace

std::vector<CachedArchive> cached_archives(const fs::path& cache) {
  std::vector<CachedArchive> archives;
  std::error_code error;
  for (fs::directory_iterator entry(cache, error), end; !error && entry != end;
       entry.increment(error)) {
    if (!is_cached_archive(entry->path())) continue;
    std::error_code ignored;
    archives.push_back({.folder = entry->path(),
                        .bytes = bytes_in(entry->path()),
                        .used = fs::last_write_time(entry->path(), ignored)});
  }
  std::ranges::sort(archives, {}, &CachedArchive::used);
  return archives;
}

void remove_cached(const CachedArchive& archive) {
  // Under another name first: half of an archive must never be taken for the whole.
  fs::path folder = archive.folder;
  std::error_code ignored;
  if (folder.extension() != ".partial") {
    folder += ".partial";
    fs::rename(archive.folder, folder, ignored);
  }
  fs::remove_all(folder, ignored);
}

void limit_cache(const fs::path& cache, std::uintmax_t largest) {
  const auto yesterday = fs::file_time_type::clock::now() - std::chrono::hours(24);
  const std::vector<CachedArchive> archives = cached_archives(cache);
  std::uintmax_t total = 0;
  for (const CachedArchive& archive : archives) total += archive.bytes;
  for (const CachedArchive& archive : archives) {
    if (total <= largest || archive.used > yesterday) return;
    remove_cached(archive);
    total -= archive.bytes;
  }
}

}  // namespace edvo
