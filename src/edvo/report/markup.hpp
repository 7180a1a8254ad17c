// SPDX-License-Identifier: MIT
// Text inside HTML and SVG.
#pragma once

#include <string>
#include <string_view>

namespace edvo {

// The text as valid UTF-8, with & < > " ' spelled so that it can stand between tags and in
// attributes.
[[nodiscard]] std::string escape_markup(std::string_view text);

}  // namespace edvo
