// SPDX-License-Identifier: MIT
#include "edvo/saved_map/map_lock.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/output_file.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace edvo {
namespace {

// False if another program has removed the file since it was opened.
bool is_at(const std::filesystem::path& path, int descriptor) {
  struct stat opened {
  }, found{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &found) == 0 &&
         opened.st_ino == found.st_ino && opened.st_dev == found.st_dev;
}

}  // namespace

MapLock::MapLock(const std::filesystem::path& map) : path_(followed(map)) {
  path_ += ".lock";
  while (true) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    const bool is_locked = descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
    const int reason = errno;
    if (is_locked && is_at(path_, descriptor_)) return;
    if (descriptor_ >= 0) ::close(descriptor_);
    if (is_locked || reason == EINTR) continue;
    if (reason == EWOULDBLOCK)
      throw Error(ErrorCode::kMap,
                  fmt::format("{}: another program is about to write this map; wait for its end, "
                              "or give another file",
                              map.string()));
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: cannot be written, {}", path_.string(), std::strerror(reason)));
  }
}

MapLock::~MapLock() {
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

}  // namespace edvo
