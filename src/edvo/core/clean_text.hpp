// SPDX-License-Identifier: MIT
// Makes text from outside safe to print.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace edvo {

struct Utf8Character {
  char32_t code = 0;
  std::size_t bytes = 0;  // 0 = not UTF-8
};

// The first character of a text that is not empty (RFC 3629).
[[nodiscard]] Utf8Character first_utf8_character(std::string_view text);

// The text as valid UTF-8 without control characters: '?' replaces each byte that is not UTF-8 and
// each character that controls a terminal or changes the writing direction. Line breaks and tabs
// stay.
[[nodiscard]] std::string clean_text(std::string_view text);

}  // namespace edvo
