// SPDX-License-Identifier: MIT
#include "edvo/io/download.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/curl_library.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

namespace edvo {
namespace {

namespace fs = std::filesystem;

constexpr long kMostRedirects = 10;
constexpr long kLeastSpeed = 1024;  // [bytes/s]
constexpr long kPartialContent = 206, kRangeNotSatisfiable = 416;
constexpr const char* kRemedy =
    "; check the network, take another address with --url, or give the "
    "file with --from FILE";

[[noreturn]] void fail_output(const fs::path& file, const std::string& reason) {
  throw Error(ErrorCode::kOutput, fmt::format("{}: {}", file.string(), reason));
}

// A file that grows at its end, held by one process at a time.
class PartFile {
 public:
  explicit PartFile(const fs::path& path)
      : path_(path),
        descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644)) {
    if (descriptor_ < 0) fail_output(path, std::strerror(errno));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
    ::close(descriptor_);
    fail_output(path, "another program is downloading this file; wait for it");
  }
  ~PartFile() { ::close(descriptor_); }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  [[nodiscard]] std::int64_t size() const {
    struct stat status {};
    return ::fstat(descriptor_, &status) == 0 ? status.st_size : 0;
  }

  void clear() {
    if (::ftruncate(descriptor_, 0) != 0) fail_output(path_, std::strerror(errno));
  }

  [[nodiscard]] bool append(const char* bytes, std::size_t count) {
    while (count > 0) {
      const ssize_t written = ::write(descriptor_, bytes, count);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return false;
      bytes += written;
      count -= static_cast<std::size_t>(written);
    }
    return true;
  }

 private:
  fs::path path_;
  int descriptor_;
};

enum class Stop { kNone, kAsked, kTooLong, kNoRange, kDisk };

// One request. libcurl calls back into it; no exception may pass through libcurl.
class Request {
 public:
  Request(const CurlLibrary& curl, const Download& wanted, PartFile& file)
      : curl_(curl), wanted_(wanted), file_(file), start_(file.size()), size_(start_) {
    handle_ = Handle(curl.init(), curl.cleanup);
    if (!handle_) throw Error(ErrorCode::kModel, "libcurl could not be started");
    const auto set = [this](CURLoption option, auto value) {
      curl_.setopt(handle_.get(), option, value);
    };
    set(CURLOPT_URL, wanted.url.c_str());
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
    set(CURLOPT_FOLLOWLOCATION, 1L);
    set(CURLOPT_MAXREDIRS, kMostRedirects);
    set(CURLOPT_FAILONERROR, 1L);
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_USERAGENT, "edvo/" EDVO_VERSION);
    set(CURLOPT_CONNECTTIMEOUT, static_cast<long>(wanted.max_lost_frames));
    set(CURLOPT_LOW_SPEED_LIMIT, kLeastSpeed);
    set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(wanted.max_lost_frames));
    set(CURLOPT_ERRORBUFFER, message_.data());
    if (start_ > 0) set(CURLOPT_RANGE, range_.assign(fmt::format("{}-", start_)).c_str());
    set(CURLOPT_WRITEFUNCTION, &Request::on_data);
    set(CURLOPT_WRITEDATA, static_cast<void*>(this));
    set(CURLOPT_NOPROGRESS, 0L);
    set(CURLOPT_XFERINFOFUNCTION, &Request::on_progress);
    set(CURLOPT_XFERINFODATA, static_cast<void*>(this));
  }

  void run() { result_ = curl_.perform(handle_.get()); }

  // The part does not fit what the server has or can: all has to come again.
  [[nodiscard]] bool must_start_over() const {
    return start_ > 0 && (stop_ == Stop::kNoRange || status() == kRangeNotSatisfiable);
  }

  [[nodiscard]] bool was_stopped() const { return stop_ == Stop::kAsked; }

  void check(const fs::path& path) const {
    if (stop_ == Stop::kDisk) fail_output(path, std::strerror(disk_error_));
    if (stop_ == Stop::kTooLong)
      fail(fmt::format("it sends more than the {} bytes that are expected", wanted_.bytes));
    if (result_ == CURLE_HTTP_RETURNED_ERROR)
      fail(fmt::format("the server answers {}{}", status(),
                       status() == 404 ? ", no such file" : ""));
    if (result_ == CURLE_OPERATION_TIMEDOUT)
      fail(
          fmt::format("no data, or next to none, for {} s; {} of {} bytes are here, the same "
                      "command goes on from there",
                      wanted_.max_lost_frames, size_, wanted_.bytes));
    if (result_ == CURLE_PARTIAL_FILE || (result_ == CURLE_OK && size_ < wanted_.bytes))
      fail(fmt::format("it ended after {} of {} bytes; the same command goes on from there", size_,
                       wanted_.bytes));
    if (result_ != CURLE_OK) fail(message_[0] != '\0' ? message_.data() : curl_.strerror(result_));
  }

 private:
  using Handle = std::unique_ptr<CURL, decltype(&curl_easy_cleanup)>;

  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(ErrorCode::kModel,
                fmt::format("{}: cannot be downloaded: {}{}", wanted_.url, reason, kRemedy));
  }

  [[nodiscard]] long status() const {
    long code = 0;
    curl_.getinfo(handle_.get(), CURLINFO_RESPONSE_CODE, &code);
    return code;
  }

  // Returning another count ends the transfer.
  std::size_t take(const char* bytes, std::size_t count) {
    if (start_ > 0 && size_ == start_ && status() != kPartialContent) {
      stop_ = Stop::kNoRange;
    } else if (size_ + static_cast<std::int64_t>(count) > wanted_.bytes) {
      stop_ = Stop::kTooLong;
    } else if (!file_.append(bytes, count)) {
      stop_ = Stop::kDisk;
      disk_error_ = errno;
    }
    if (stop_ != Stop::kNone) return count == 0 ? 1 : 0;
    size_ += static_cast<std::int64_t>(count);
    return count;
  }

  static std::size_t on_data(char* bytes, std::size_t size, std::size_t count, void* self) {
    return static_cast<Request*>(self)->take(bytes, size * count);
  }

  static int on_progress(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    auto& request = *static_cast<Request*>(self);
    if (!request.wanted_.on_progress || request.wanted_.on_progress(request.size_)) return 0;
    request.stop_ = Stop::kAsked;
    return 1;
  }

  const CurlLibrary& curl_;
  const Download& wanted_;
  PartFile& file_;
  std::int64_t start_, size_;  // [bytes]
  Handle handle_{nullptr, nullptr};
  std::string range_;
  std::array<char, CURL_ERROR_SIZE> message_ = {};
  CURLcode result_ = CURLE_OK;
  Stop stop_ = Stop::kNone;
  int disk_error_ = 0;
};

}  // namespace

bool download(const Download& download, const fs::path& file) {
  const CurlLibrary curl = load_curl();
  PartFile part(file);
  if (part.size() == download.bytes) return true;
  if (part.size() > download.bytes) part.clear();
  Request request(curl, download, part);
  request.run();
  if (!request.must_start_over()) {
    if (request.was_stopped()) return false;
    request.check(file);
    return true;
  }
  part.clear();
  Request whole(curl, download, part);
  whole.run();
  if (whole.was_stopped()) return false;
  whole.check(file);
  return true;
}

}  // namespace edvo
