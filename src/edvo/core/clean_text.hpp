// SPDX-License-Identifier: MIT
// Makes text from outside safe to print.
#pragma once

#include <string>
#include <string_view>

namespace edvo {

// The text as valid UTF-8 without control characters: '?' replaces each byte that is not UTF-8 and
// each character that controls a terminal or changes the writing direction. Line breaks and tabs
// stay.
[[nodiscard]] std::string clean_text(std::string_view text);

}  // namespace edvo
