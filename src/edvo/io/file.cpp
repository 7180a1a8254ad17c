// SPDX-License-Identifier: MIT
#include "edvo/io/file.hpp"

#include "edvo/core/error.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace edvo {
namespace {

[[noreturn]] void fail_input(const std::filesystem::path& path, const std::string& reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", path.string(), reason));
}

struct Descriptor {
  explicit Descriptor(int opened) : number(opened) {}
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int number;
};

}  // namespace

std::string read_file(const std::filesystem::path& path, std::size_t largest) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) fail_input(path, "no such file");
  if (error) fail_input(path, error.message());
  if (status.type() != std::filesystem::file_type::regular) fail_input(path, "not a regular file");

  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) fail_input(path, error.message());
  if (size > largest)
    fail_input(path, fmt::format("{} bytes is too large, the limit is {}", size, largest));

  std::ifstream file(path, std::ios::binary);
  if (!file) fail_input(path, fmt::format("cannot be opened, {}", std::strerror(errno)));
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (file.bad() || file.gcount() != static_cast<std::streamsize>(size))
    fail_input(path, fmt::format("read {} of {} bytes", file.gcount(), size));
  return bytes;
}

std::string read_stream(const std::filesystem::path& path, std::size_t largest,
                        std::chrono::milliseconds patience) {
  // Opening a pipe that nobody writes to would wait for ever.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (file.number < 0) fail_input(path, std::strerror(errno));
  std::string bytes;
  std::vector<char> block(1 << 16);
  while (true) {
    pollfd ready{.fd = file.number, .events = POLLIN, .revents = 0};
    const int count = ::poll(&ready, 1, static_cast<int>(patience.count()));
    if (count == 0) fail_input(path, "nothing arrives from this pipe");
    const ssize_t size = count < 0 ? -1 : ::read(file.number, block.data(), block.size());
    if (size < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (size < 0) fail_input(path, std::strerror(errno));
    if (size == 0) return bytes;
    bytes.append(block.data(), static_cast<std::size_t>(size));
    if (bytes.size() > largest)
      fail_input(path, fmt::format("more than {} bytes is too large", largest));
  }
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  const bool opened = file.is_open();
  if (opened) {
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
  }
  if (file) return;
  const int reason = errno;
  std::error_code ignored;
  if (opened && std::filesystem::is_regular_file(path, ignored))
    std::filesystem::remove(path, ignored);
  throw Error(ErrorCode::kOutput,
              fmt::format("{}: cannot be written, {}", path.string(),
                          reason != 0 ? std::strerror(reason) : "unknown reason"));
}

}  // namespace edvo
