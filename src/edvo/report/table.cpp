// SPDX-License-Identifier: MIT
#include "edvo/report/table.hpp"

#include "edvo/core/clean_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace edvo {
namespace {

using Row = std::vector<std::string>;

// Characters on the screen, not bytes: UTF-8's continuation bytes do not count.
std::size_t width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t columns, bool left) {
  const std::string space(columns - std::min(columns, width(text)), ' ');
  return left ? text + space : space + text;
}

std::string text_row(const Row& row, const std::vector<std::size_t>& widths,
                     std::string_view separator) {
  std::string line;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += separator;
    line += padded(row[i], widths[i], i == 0);
  }
  return line;
}

std::vector<std::size_t> column_widths(const Table& table) {
  std::vector<std::size_t> widths;
  for (std::size_t i = 0; i < table.header.size(); ++i) {
    widths.push_back(width(table.header[i]));
    for (const Row& row : table.rows) widths[i] = std::max(widths[i], width(row[i]));
  }
  return widths;
}

std::string as_text(const Table& table) {
  const std::vector<std::size_t> widths = column_widths(table);
  std::string text = text_row(table.header, widths, "  ") + '\n';
  for (const Row& row : table.rows) text += text_row(row, widths, "  ") + '\n';
  return text;
}

// A cell is one line, whatever it holds.
std::string on_one_line(std::string_view cell) {
  std::string line = clean_text(cell);
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return line;
}

bool is_letter_or_digit(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0;
}

// HTML and links are Markdown, too. An underscore within a word is none.
std::string markdown_cell(std::string_view cell) {
  const std::string line = on_one_line(cell);
  std::string escaped;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const bool in_word = i > 0 && i + 1 < line.size() && is_letter_or_digit(line[i - 1]) &&
                         is_letter_or_digit(line[i + 1]);
    const bool is_markup = std::string_view("|\\`*<>&~").find(line[i]) != std::string_view::npos;
    const bool opens_link = line[i] == '[' && line.find("](", i) != std::string::npos;
    if (is_markup || opens_link || (line[i] == '_' && !in_word)) escaped += '\\';
    escaped += line[i];
  }
  return escaped;
}

std::string as_markdown(Table table) {
  for (std::string& cell : table.header) cell = markdown_cell(cell);
  for (Row& row : table.rows)
    for (std::string& cell : row) cell = markdown_cell(cell);
  const std::vector<std::size_t> widths = column_widths(table);
  std::string text = "| " + text_row(table.header, widths, " | ") + " |\n|";
  for (std::size_t i = 0; i < widths.size(); ++i) {
    const std::string dashes(std::max<std::size_t>(widths[i] + 1, 3), '-');
    text += i == 0 ? dashes + "-|" : dashes + ":|";
  }
  text += '\n';
  for (const Row& row : table.rows) text += "| " + text_row(row, widths, " | ") + " |\n";
  return text;
}

std::string csv_cell(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string latex_cell(const std::string& cell) {
  std::string escaped;
  for (const char c : on_one_line(cell)) {
    if (c == '\\') {
      escaped += "\\textbackslash{}";
    } else if (c == '~') {
      escaped += "\\textasciitilde{}";
    } else if (c == '^') {
      escaped += "\\textasciicircum{}";
    } else if (c == '<' || c == '>') {  // other characters in the oldest font encoding
      escaped += c == '<' ? "\\textless{}" : "\\textgreater{}";
    } else {
      if (std::string_view("&%$#_{}").find(c) != std::string_view::npos) escaped += '\\';
      escaped += c;
    }
  }
  return escaped;
}

template <typename CellFormat>
std::string joined(const Row& row, std::string_view separator, CellFormat format) {
  std::string line;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (i > 0) line += separator;
    line += format(row[i]);
  }
  return line;
}

std::string as_csv(const Table& table) {
  std::string text = joined(table.header, ",", csv_cell) + '\n';
  for (const Row& row : table.rows) text += joined(row, ",", csv_cell) + '\n';
  return text;
}

std::string as_latex(const Table& table) {
  std::string text =
      fmt::format("\\begin{{tabular}}{{l{}}}\n\\hline\n",
                  std::string(std::max<std::size_t>(table.header.size(), 1) - 1, 'r'));
  text += joined(table.header, " & ", latex_cell) + " \\\\\n\\hline\n";
  for (const Row& row : table.rows) text += joined(row, " & ", latex_cell) + " \\\\\n";
  return text + "\\hline\n\\end{tabular}\n";
}

}  // namespace

std::string format_table(const Table& table, TableFormat format) {
  switch (format) {
    case TableFormat::kText:
      return as_text(table);
    case TableFormat::kMarkdown:
      return as_markdown(table);
    case TableFormat::kCsv:
      return as_csv(table);
    case TableFormat::kLatex:
      return as_latex(table);
  }
  return {};
}

std::string format_note(const std::string& note, TableFormat format) {
  const std::string line = on_one_line(note);
  switch (format) {
    case TableFormat::kText:
      return line + '\n';
    case TableFormat::kMarkdown:
      return '\n' + markdown_cell(line) + "\n\n";  // a paragraph of its own
    case TableFormat::kCsv:
      return "# " + line + '\n';
    case TableFormat::kLatex:
      return "% " + line + '\n';
  }
  return {};
}

std::string format_command(const std::string& intro, const std::string& command,
                           TableFormat format) {
  const bool is_code = format == TableFormat::kMarkdown && command.find('`') == std::string::npos;
  if (!is_code) return format_note(intro + command, format);
  return '\n' + markdown_cell(intro) + '`' + on_one_line(command) + "`\n\n";
}

}  // namespace edvo
