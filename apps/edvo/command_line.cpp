// SPDX-License-Identifier: MIT
#include "command_line.hpp"

#include <cctype>
#include <fstream>
#include <string_view>

namespace edvo::app {

std::string shell_quoted(const std::string& argument) {
  constexpr std::string_view kHarmless = "@%+=:,./-_";
  bool plain = !argument.empty();
  for (const char c : argument)
    plain = plain && (std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                      kHarmless.find(c) != std::string_view::npos);
  if (plain) return argument;
  std::string quoted = "'";
  for (const char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string this_command() {
  std::ifstream stream("/proc/self/cmdline", std::ios::binary);
  std::string command;
  for (std::string argument; std::getline(stream, argument, '\0');)
    command += (command.empty() ? "" : " ") + shell_quoted(argument);
  return command;
}

}  // namespace edvo::app
