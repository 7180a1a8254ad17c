// SPDX-License-Identifier: MIT
// The hint for a word that is nearly a known one.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace edvo {

// ", did you mean 'levels'?" with the nearest candidate; empty where none is near enough to be a
// slip of the fingers.
[[nodiscard]] std::string did_you_mean(std::string_view word,
                                       std::span<const std::string> candidates);

}  // namespace edvo
