// SPDX-License-Identifier: MIT
// How deeply a text nests, found before a parser that calls itself reads it.
#pragma once

#include <optional>
#include <string_view>

namespace edvo {

// No file of ours nests more than four deep.
inline constexpr int kDeepestNesting = 32;

// The first line [1..] where the TOML text opens more than kDeepestNesting brackets and braces
// within each other, or joins more than that many parts of a key by dots; empty if there is none.
[[nodiscard]] std::optional<int> line_nested_too_deeply_in_toml(std::string_view text);

// The same of JSON text, for brackets and braces.
[[nodiscard]] std::optional<int> line_nested_too_deeply_in_json(std::string_view text);

}  // namespace edvo
