// SPDX-License-Identifier: MIT
// What a text may not hold, found before a parser reads it that cannot cope with it.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace edvo {

// edvo's own files nest at most four deep.
inline constexpr int kDeepestNesting = 32;

struct TomlFault {
  int line = 1;           // [1..]
  std::string_view what;  // "nested too deeply"
};

// The first place where the TOML text opens more than kDeepestNesting brackets and braces within
// each other, joins more than that many parts of a key by dots, or has a character outside of
// quotes and comments that is not ASCII: no TOML, but toml++ 3.3 takes it for impossible. Empty if
// there is none.
[[nodiscard]] std::optional<TomlFault> fault_in_toml(std::string_view text);

// The end of the string or comment that begins at i; i if none does. A string that is not closed
// ends with its line, or with the text if it may have several lines.
[[nodiscard]] std::size_t end_of_toml_string_or_comment(std::string_view text, std::size_t i);

// The first line [1..] where the JSON text opens more than kDeepestNesting brackets and braces
// within each other; empty if there is none.
[[nodiscard]] std::optional<int> line_nested_too_deeply_in_json(std::string_view text);

}  // namespace edvo
