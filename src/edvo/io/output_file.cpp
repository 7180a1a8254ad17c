// SPDX-License-Identifier: MIT
#include "edvo/io/output_file.hpp"

#include "edvo/core/error.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace edvo {
namespace {

namespace fs = std::filesystem;

Error write_error(const fs::path& path, int error_number) {
  const char* remedy = "choose another place";
  if (error_number == ENOSPC || error_number == EDQUOT) remedy = "free some space on that disk";
  if (error_number == EACCES || error_number == EROFS || error_number == EPERM)
    remedy = "choose a folder that you may write to";
  return {ErrorCode::kOutput, fmt::format("{}: cannot write: {}; {}", path.string(),
                                          std::strerror(error_number), remedy)};
}

// True for what has no content to keep, as a FIFO or a device: it is written straight into.
bool is_special(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

// Standard output, where the path names what it goes to (/dev/stdout). A descriptor of our own
// would begin at the start of that file again, over what is printed.
int open_printed(const fs::path& path) {
  struct stat printed {
  }, found{};
  const bool same = ::fstat(STDOUT_FILENO, &printed) == 0 && ::stat(path.c_str(), &found) == 0 &&
                    !S_ISDIR(found.st_mode) && printed.st_ino == found.st_ino &&
                    printed.st_dev == found.st_dev;
  return same ? ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0) : -1;
}

int open_for_writing(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) throw write_error(path, errno);
  return descriptor;
}

// 0, or the error number. Goes on after short writes and interrupting signals.
int write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

// False if what is written to the descriptor will not be found at the path.
bool is_at(const fs::path& path, int descriptor) {
  struct stat opened {
  }, found{};
  if (::fstat(descriptor, &opened) != 0 || ::stat(path.c_str(), &found) != 0) return false;
  return opened.st_ino == found.st_ino && opened.st_dev == found.st_dev;
}

}  // namespace

LineFile::LineFile(fs::path path) : path_(std::move(path)), descriptor_(open_for_writing(path_)) {}

LineFile::~LineFile() {
  ::close(descriptor_);
}

void LineFile::append(std::string_view line) {
  if (!is_at(path_, descriptor_))
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: was removed, moved or replaced while it was being written",
                            path_.string()));
  std::string with_end(line);
  with_end += '\n';
  if (const int error = write_all(descriptor_, with_end); error != 0) {
    // Half a line would make the file invalid. A device (as /dev/full) cannot be cut: nothing to
    // do.
    if (::ftruncate(descriptor_, whole_bytes_) == 0) ::lseek(descriptor_, whole_bytes_, SEEK_SET);
    throw write_error(path_, error);
  }
  whole_bytes_ += static_cast<std::int64_t>(with_end.size());
}

WholeFile::WholeFile(fs::path path) : path_(std::move(path)) {
  descriptor_ = open_printed(path_);
  if (descriptor_ >= 0) return;
  if (is_special(path_)) {
    descriptor_ = open_for_writing(path_);
    return;
  }
  place_ = followed(path_);
  unfinished_ = place_;
  unfinished_ += ".part";
  descriptor_ = open_for_writing(unfinished_);
}

WholeFile::~WholeFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (!unfinished_.empty()) ::unlink(unfinished_.c_str());
}

void WholeFile::append(std::string_view bytes) {
  if (const int error = write_all(descriptor_, bytes); error != 0) fail(error);
}

void WholeFile::commit() {
  // Some file systems report a full disk or a lost server only here.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) fail(errno);
  if (::close(std::exchange(descriptor_, -1)) != 0) fail(errno);
  if (!unfinished_.empty() && ::rename(unfinished_.c_str(), place_.c_str()) != 0) fail(errno);
}

void WholeFile::fail(int error_number) {
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  if (!unfinished_.empty()) ::unlink(unfinished_.c_str());
  throw write_error(path_, error_number);
}

fs::path followed(fs::path path) {
  constexpr int kMostLinks = 40;  // as Linux
  const fs::path named = path;
  std::error_code error;
  for (int i = 0; fs::is_symlink(path, error); ++i) {
    if (i == kMostLinks) throw write_error(named, ELOOP);
    const fs::path target = fs::read_symlink(path, error);
    if (error) throw write_error(named, error.value());
    path = target.is_absolute() ? target : path.parent_path() / target;
  }
  return path;
}

bool would_be_lost(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && !fs::is_empty(path, error);
}

void write_whole(const fs::path& path, std::string_view content) {
  WholeFile file(path);
  file.append(content);
  file.commit();
}

void make_folder(const fs::path& folder, std::string_view remedy) {
  std::error_code error;
  if (!folder.empty()) fs::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::kOutput, fmt::format("{}: cannot make this folder: {}{}",
                                                folder.string(), error.message(), remedy));
}

}  // namespace edvo
