// SPDX-License-Identifier: MIT
// Text lists: one record per line, fields separated by blanks or commas, comment lines with '#'.
#pragma once

#include "edvo/core/stamp.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

struct ListLine {
  int number = 0;  // in the file, counted from 1
  std::vector<std::string> fields;
};

// Reads every line that is neither blank nor a comment. Takes Windows line ends, a byte order mark
// and quotes around fields. Throws Error(kInput) "FILE:LINE: expected 2 fields, got 1".
[[nodiscard]] std::vector<ListLine> read_list(const std::filesystem::path& file,
                                              std::size_t fields_per_line);

// The time stamp in a field. Throws Error(kInput) naming file, line and value.
[[nodiscard]] Stamp stamp_field(const std::filesystem::path& file, const ListLine& line,
                                std::size_t field);

// Text of unknown origin, made fit for a message: shortened, without control characters.
[[nodiscard]] std::string printable(std::string_view text);

}  // namespace edvo
