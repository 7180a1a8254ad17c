// SPDX-License-Identifier: MIT
// What the program says about a command line that it does not understand.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace edvo::app {

// One line: the error, the nearest known verb or option, and where the help is.
[[nodiscard]] std::string explain(const CLI::App& program, const CLI::ParseError& error,
                                  const std::string& first_word);

}  // namespace edvo::app
