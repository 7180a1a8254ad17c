// SPDX-License-Identifier: MIT
// Suggests a known word for a misspelled one.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace edvo {

// ", did you mean 'levels'?" with the nearest candidate; empty if no candidate is close
// enough for a typing error.
[[nodiscard]] std::string did_you_mean(std::string_view word,
                                       std::span<const std::string> candidates);

}  // namespace edvo
