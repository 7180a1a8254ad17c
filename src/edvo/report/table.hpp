// SPDX-License-Identifier: MIT
// Tables of text in the notations that people paste into terminals, pages, sheets and papers.
#pragma once

#include "edvo/core/fields.hpp"

#include <string>
#include <vector>

namespace edvo {

enum class TableFormat { kText, kMarkdown, kCsv, kLatex };

template <>
struct EnumNames<TableFormat> {
  static constexpr auto names = std::to_array<std::pair<TableFormat, std::string_view>>({
      {TableFormat::kText, "text"},
      {TableFormat::kMarkdown, "markdown"},
      {TableFormat::kCsv, "csv"},
      {TableFormat::kLatex, "latex"},
  });
};

// The first column holds names and is set flush left, the others numbers, flush right.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  // each as long as the header
};

// Whatever a format treats as markup is escaped. Ends with a line break.
[[nodiscard]] std::string format_table(const Table& table, TableFormat format);

// A line beside the table: a comment where the format has them, else a line or paragraph of its
// own.
[[nodiscard]] std::string format_note(const std::string& line, TableFormat format);

// The same of a command for the shell, which stays as it is to be typed.
[[nodiscard]] std::string format_command(const std::string& intro, const std::string& command,
                                         TableFormat format);

}  // namespace edvo
