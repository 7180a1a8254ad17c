// SPDX-License-Identifier: MIT
// Text inside HTML and SVG.
#pragma once

#include <string>
#include <string_view>

namespace edvo {

// The text as valid UTF-8, with & < > " ' spelled so that it can stand between tags and in
// attributes.
[[nodiscard]] std::string escape_markup(std::string_view text);

// The bytes in the alphabet of RFC 4648, for data: URLs.
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace edvo
