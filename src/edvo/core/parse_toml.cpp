// SPDX-License-Identifier: MIT
#include "edvo/core/parse_toml.hpp"

#include "edvo/core/clean_text.hpp"
#include "edvo/core/nesting.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace edvo {
namespace {

bool is_ascii(char c) {
  return static_cast<unsigned char>(c) < 0x80;
}

std::string comment_in_ascii(std::string_view comment) {
  std::string ascii(comment);
  std::replace_if(
      ascii.begin(), ascii.end(), [](char c) { return !is_ascii(c); }, '?');
  return ascii;
}

// A literal string has no escapes, so it becomes a basic one.
std::string string_in_ascii(std::string_view quoted) {
  const char quote = quoted.front();
  const std::size_t width = quoted.starts_with(std::string(3, quote)) ? 3 : 1;
  const bool is_closed = quoted.size() >= 2 * width && quoted.ends_with(std::string(width, quote));
  std::string ascii(width, '"');
  std::string_view rest = quoted.substr(width, quoted.size() - width * (is_closed ? 2 : 1));
  while (!rest.empty()) {
    const char c = rest.front();
    const Utf8Character character = first_utf8_character(rest);
    std::size_t bytes = std::max<std::size_t>(1, character.bytes);
    if (!is_ascii(c)) {
      // A surrogate is no character either: the parser says so.
      ascii += fmt::format("\\U{:08X}",
                           character.bytes > 0 ? static_cast<unsigned>(character.code) : 0xD800U);
    } else if (quote == '\'' && (c == '"' || c == '\\')) {
      ascii += {'\\', c};
    } else if (c == '\\' && rest.size() > 1) {
      ascii += {c, is_ascii(rest[1]) ? rest[1] : '?'};  // "\?" is no escape
      bytes = is_ascii(rest[1])
                  ? 2
                  : 1 + std::max<std::size_t>(1, first_utf8_character(rest.substr(1)).bytes);
    } else {
      ascii += c;
    }
    rest.remove_prefix(bytes);
  }
  return is_closed ? ascii.append(width, '"') : ascii;
}

}  // namespace

std::string toml_in_ascii(std::string_view text) {
  std::string ascii;
  ascii.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t end = end_of_toml_string_or_comment(text, i);
    const std::string_view part = text.substr(i, std::max(end, i + 1) - i);
    if (end == i || std::all_of(part.begin(), part.end(), is_ascii)) {
      ascii += part;
    } else {
      ascii += part.front() == '#' ? comment_in_ascii(part) : string_in_ascii(part);
    }
    i += part.size();
  }
  return ascii;
}

toml::table parse_toml(std::string_view text, const std::string& source, ErrorCode code) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (const auto fault = fault_in_toml(text))
    throw Error(code, fmt::format("{}:{}: {}", source, fault->line, fault->what));
  try {
    return toml::parse(toml_in_ascii(text), source);
  } catch (const toml::parse_error& error) {
    throw Error(code, fmt::format("{}:{}: not valid TOML: {}", source, error.source().begin.line,
                                  error.description()));
  }
}

}  // namespace edvo
