// SPDX-License-Identifier: MIT
// What the program says. Names of files come from outside and may hold anything: nothing that
// controls a terminal is passed on.
#pragma once

#include <fmt/core.h>

#include <string_view>
#include <utility>

namespace edvo::app {

// To stderr. What cannot be said (a closed pipe, a full disk) is no reason to stop.
void say_text(std::string_view text);

// The same, byte by byte: for what rewrites a line of the terminal.
void say_bytes(std::string_view bytes);

// To stdout. Throws Error(kOutput).
void print_text(std::string_view text);

// To stdout, byte by byte: for formats that say themselves what they may hold.
void print_bytes(std::string_view bytes);

// Throws Error(kOutput) where stdout has not taken everything that was printed.
void finish_printing();

template <typename... Arguments>
void say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  say_text(fmt::format(format, std::forward<Arguments>(arguments)...));
}

template <typename... Arguments>
void print(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  print_text(fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace edvo::app
