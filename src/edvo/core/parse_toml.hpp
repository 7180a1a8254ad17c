// SPDX-License-Identifier: MIT
// TOML that anyone may have written.
#pragma once

#include "edvo/core/error.hpp"
#include "edvo/core/toml.hpp"

#include <string>
#include <string_view>

namespace edvo {

// The same TOML with nothing but ASCII: other characters are escaped in strings and replaced by '?'
// in comments; elsewhere it has none (fault_in_toml). toml++ 3.3 takes some of them for impossible
// where damaged text leads it to look at them, and there the compiler may do as it likes.
[[nodiscard]] std::string toml_in_ascii(std::string_view text);

// Throws Error(code), "source:line: what", if the text is not TOML or nested too deeply. Positions
// of nodes are right by line, not by column.
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::string& source,
                                     ErrorCode code);

}  // namespace edvo
