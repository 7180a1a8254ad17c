// SPDX-License-Identifier: MIT
#include "edvo/io/archive.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/archive_cache.hpp"
#include "edvo/io/text_list.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBlock = std::size_t{1} << 18;  // [bytes] handed from the archive to a file
constexpr int kMostEntries = 2'000'000;

// Images hardly compress, so an archive that grows more than this is made to fill the disk.
constexpr std::uintmax_t kLargestGrowth = 100;
constexpr std::uintmax_t kAlwaysAllowed = std::uintmax_t{1} << 26;  // [bytes], for tiny archives

[[noreturn]] void fail_input(const fs::path& archive, std::string_view reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", archive.string(), reason));
}

[[noreturn]] void fail_output(const fs::path& place, std::string_view reason) {
  throw Error(ErrorCode::kOutput,
              fmt::format("{}: {}; the cache can be moved with XDG_CACHE_HOME, or unpack the "
                          "archive by hand and give the folder",
                          place.string(), reason));
}

struct ArchiveDelete {
  void operator()(archive* handle) const { archive_read_free(handle); }
};
using ArchiveReader = std::unique_ptr<archive, ArchiveDelete>;

// libarchive does not always know one.
std::string_view reason_of(archive* handle) {
  const char* const reason = archive_error_string(handle);
  return reason != nullptr ? reason : "unknown reason";
}

ArchiveReader open_archive(const fs::path& file) {
  ArchiveReader reader(archive_read_new());
  if (!reader) throw std::bad_alloc();
  // Only what libarchive does itself: other filters would start programs.
  archive_read_support_filter_gzip(reader.get());
  archive_read_support_filter_bzip2(reader.get());
  archive_read_support_filter_xz(reader.get());
  archive_read_support_filter_zstd(reader.get());
  archive_read_support_format_tar(reader.get());
  archive_read_support_format_zip_seekable(reader.get());  // needs the directory at its end
  if (archive_read_open_filename(reader.get(), file.c_str(), kBlock) != ARCHIVE_OK)
    fail_input(file, fmt::format("neither a folder nor a readable tar or zip archive, {}",
                                 reason_of(reader.get())));
  return reader;
}

// A folder that disappears with its owner unless it is kept.
class Scratch {
 public:
  explicit Scratch(fs::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    fs::create_directory(folder_, error);
    if (error) fail_output(folder_, error.message());
  }
  ~Scratch() {
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] const fs::path& folder() const { return folder_; }

  void keep_as(const fs::path& target) {
    std::error_code error;
    fs::rename(folder_, target, error);
    if (error) fail_output(target, error.message());
    folder_.clear();
  }

 private:
  fs::path folder_;
};

// Held by one process at a time for one cache; given back by the system if that process dies.
class Lock {
 public:
  explicit Lock(const fs::path& cache)
      : descriptor_(open(cache.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0) fail_output(cache, std::strerror(errno));
    while (flock(descriptor_, LOCK_EX) != 0)
      if (errno != EINTR) break;  // file systems without locks: rename() alone keeps us whole
  }
  ~Lock() { close(descriptor_); }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int descriptor_;
};

// The entry's path below the folder it is unpacked to; throws if it leads out of it.
fs::path safe_path(const fs::path& archive, archive_entry* entry) {
  const char* name = archive_entry_pathname(entry);
  if (name == nullptr) name = archive_entry_pathname_utf8(entry);
  if (name == nullptr) fail_input(archive, "an entry has no readable name");
  const fs::path path(name);
  if (path.is_absolute() || std::ranges::find(path, "..") != path.end())
    fail_input(archive,
               fmt::format("entry {} would be written outside the folder", printable(name)));
  const bool is_link =
      archive_entry_hardlink(entry) != nullptr || archive_entry_symlink(entry) != nullptr;
  const auto type = archive_entry_filetype(entry);
  if (is_link || (type != AE_IFREG && type != AE_IFDIR))
    fail_input(archive, fmt::format("entry {} is neither a plain file nor a folder; unpack the "
                                    "archive by hand and give the folder",
                                    printable(name)));
  return path.lexically_normal();
}

class Unpacker {
 public:
  Unpacker(const fs::path& archive, const std::function<void(double)>& on_progress)
      : archive_(archive),
        reader_(open_archive(archive)),
        on_progress_(on_progress),
        block_(kBlock) {
    std::error_code error;
    packed_size_ = fs::file_size(archive, error);
    if (error) fail_input(archive, error.message());
  }

  void unpack_to(const fs::path& folder) {
    archive_entry* entry = nullptr;
    int entries = 0;
    for (int status = 0;
         (status = archive_read_next_header(reader_.get(), &entry)) != ARCHIVE_EOF;) {
      if (status != ARCHIVE_OK && status != ARCHIVE_WARN) fail_damaged();
      if (++entries > kMostEntries) fail_input(archive_, "too many entries");
      const fs::path target = folder / safe_path(archive_, entry);
      const bool is_folder = archive_entry_filetype(entry) == AE_IFDIR;
      std::error_code error;
      fs::create_directories(is_folder ? target : target.parent_path(), error);
      if (error) fail_output(target, error.message());
      if (!is_folder) unpack_file(target);
      report();
    }
    if (entries == 0) fail_input(archive_, "the archive is empty");
  }

 private:
  void unpack_file(const fs::path& target) {
    errno = 0;
    std::ofstream file(target, std::ios::binary | std::ios::trunc);
    while (file) {
      const la_ssize_t size = archive_read_data(reader_.get(), block_.data(), block_.size());
      if (size < 0) fail_damaged();
      if (size == 0) break;
      unpacked_size_ += static_cast<std::uintmax_t>(size);
      if (unpacked_size_ > kAlwaysAllowed && unpacked_size_ / kLargestGrowth > packed_size_)
        fail_input(archive_, fmt::format("unpacks to more than {} times its size of {} bytes",
                                         kLargestGrowth, packed_size_));
      file.write(block_.data(), size);
    }
    file.close();
    if (!file)
      fail_output(target, fmt::format("cannot be written, {}",
                                      errno != 0 ? std::strerror(errno) : "unknown reason"));
  }

  void report() const {
    if (!on_progress_ || packed_size_ == 0) return;
    const auto read = static_cast<double>(archive_filter_bytes(reader_.get(), -1));
    on_progress_(std::clamp(read / static_cast<double>(packed_size_), 0.0, 1.0));
  }

  [[noreturn]] void fail_damaged() const {
    fail_input(archive_, fmt::format("no tar or zip archive, or a damaged one: {}",
                                     reason_of(reader_.get())));
  }

  const fs::path& archive_;
  ArchiveReader reader_;
  const std::function<void(double)>& on_progress_;
  std::vector<char> block_;
  std::uintmax_t packed_size_ = 0, unpacked_size_ = 0;  // [bytes]
};

std::string cache_key(const fs::path& archive) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(archive, error);
  if (error) fail_input(archive, error.message());
  const auto changed =
      static_cast<std::uint64_t>(fs::last_write_time(archive, error).time_since_epoch().count());
  if (error) fail_input(archive, error.message());
  return fmt::format("{}-{:x}-{:x}", archive.filename().string(), size, changed);
}

}  // namespace

fs::path unpack_archive(const fs::path& archive, const fs::path& cache,
                        const std::function<void(double)>& on_progress) {
  if (cache.empty())
    throw Error(ErrorCode::kOutput, fmt::format("{}: no folder is known to unpack it in; set "
                                                "XDG_CACHE_HOME or HOME",
                                                archive.string()));
  const std::string key = cache_key(archive);
  const fs::path target = cache / key;
  std::error_code error;
  if (fs::is_directory(target, error)) {
    fs::last_write_time(target, fs::file_time_type::clock::now(), error);  // of its last use
    return target;
  }

  Unpacker unpacker(archive, on_progress);
  fs::create_directories(cache, error);
  if (error) fail_output(cache, error.message());
  const Lock lock(cache);
  if (fs::is_directory(target, error)) return target;  // another process was faster
  const fs::path partial = cache / (key + ".partial");
  fs::remove_all(partial, error);  // of a process that was killed
  Scratch scratch(partial);
  unpacker.unpack_to(scratch.folder());
  scratch.keep_as(target);
  fs::last_write_time(target, fs::file_time_type::clock::now(), error);
  limit_cache(cache, kLargestCache);
  return target;
}

}  // namespace edvo
