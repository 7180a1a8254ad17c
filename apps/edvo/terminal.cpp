// SPDX-License-Identifier: MIT
#include "terminal.hpp"

#include "edvo/core/clean_text.hpp"
#include "edvo/core/error.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

namespace edvo::app {
namespace {

[[noreturn]] void fail_stdout() {
  throw Error(ErrorCode::kOutput, fmt::format("standard output: cannot write: {}",
                                              std::strerror(errno != 0 ? errno : EIO)));
}

}  // namespace

void say_text(std::string_view text) {
  say_bytes(clean_text(text));
}

void say_bytes(std::string_view bytes) {
  static_cast<void>(std::fwrite(bytes.data(), 1, bytes.size(), stderr));
}

void print_text(std::string_view text) {
  print_bytes(clean_text(text));
}

void print_bytes(std::string_view bytes) {
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size()) fail_stdout();
}

void finish_printing() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) fail_stdout();
}

}  // namespace edvo::app
