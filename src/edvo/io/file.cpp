// SPDX-License-Identifier: MIT
#include "edvo/io/file.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace edvo {
namespace {

[[noreturn]] void fail_input(const std::filesystem::path& path, const std::string& reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", path.string(), reason));
}

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
