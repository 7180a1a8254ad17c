// SPDX-License-Identifier: MIT
// Text from outside, made safe to show.
#pragma once

#include <string>
#include <string_view>

namespace edvo {

// The text as valid UTF-8 that only says something: '?' stands for each byte that is no UTF-8 and
// for each character that controls a terminal or turns the direction of writing. Line breaks and
// tabs stay.
[[nodiscard]] std::string clean_text(std::string_view text);

}  // namespace edvo
