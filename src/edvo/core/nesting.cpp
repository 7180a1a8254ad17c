// SPDX-License-Identifier: MIT
#include "edvo/core/nesting.hpp"

#include <algorithm>

namespace edvo {
namespace {

// The end of the string that begins with quote at begin. A string that is not closed ends with its
// line, or with the text if it may have several lines: there a parser gives up.
std::size_t end_of_string(std::string_view text, std::size_t begin, std::string_view quote,
                          bool has_escapes) {
  const bool has_lines = quote.size() == 3;
  for (std::size_t i = begin + quote.size(); i < text.size(); ++i) {
    if (has_escapes && text[i] == '\\') {
      ++i;
    } else if (text.substr(i).starts_with(quote)) {
      return i + quote.size();
    } else if (text[i] == '\n' && !has_lines) {
      return i;
    }
  }
  return text.size();
}

}  // namespace

std::size_t end_of_toml_string_or_comment(std::string_view text, std::size_t i) {
  const std::string_view rest = text.substr(i);
  for (const std::string_view quote : {"\"\"\"", "'''", "\"", "'"})
    if (rest.starts_with(quote)) return end_of_string(text, i, quote, quote.front() == '"');
  return rest.starts_with('#') ? std::min(text.find('\n', i), text.size()) : i;
}

namespace {

std::size_t skip_json(std::string_view text, std::size_t i) {
  return text[i] == '"' ? end_of_string(text, i, "\"", true) : i;
}

constexpr std::string_view kNested = "nested too deeply";

template <typename Skip>
std::optional<TomlFault> find_fault(std::string_view text, bool is_toml, Skip skip) {
  constexpr std::string_view kEndsKey = "=,[]{}\n";
  int line = 1, depth = 0, dots = 0;
  for (std::size_t i = 0; i < text.size();) {
    if (const std::size_t end = skip(text, i); end > i) {
      line += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                          text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      i = end;
      continue;
    }
    const char c = text[i++];
    if (c == '[' || c == '{') ++depth;
    if ((c == ']' || c == '}') && depth > 0) --depth;
    if (kEndsKey.find(c) != std::string_view::npos) dots = 0;
    if (c == '.' && is_toml) ++dots;
    if (depth > kDeepestNesting || dots >= kDeepestNesting) return TomlFault{line, kNested};
    if (is_toml && static_cast<unsigned char>(c) > 0x7F)
      return TomlFault{line, "a character outside of quotes that is not ASCII"};
    if (c == '\n') ++line;
  }
  return std::nullopt;
}

}  // namespace

std::optional<TomlFault> fault_in_toml(std::string_view text) {
  return find_fault(text, true, end_of_toml_string_or_comment);
}

std::optional<int> line_nested_too_deeply_in_json(std::string_view text) {
  const auto fault = find_fault(text, false, skip_json);
  return fault ? std::optional(fault->line) : std::nullopt;
}

}  // namespace edvo
