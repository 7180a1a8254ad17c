// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/core/fields.hpp"

#include <optional>
#include <string_view>

namespace edvo {

// The enum's value of that name (EnumNames), none if there is no such name.
template <typename Enum>
[[nodiscard]] std::optional<Enum> find_named(std::string_view wanted) {
  for (const auto& [value, name] : EnumNames<Enum>::names)
    if (name == wanted) return value;
  return std::nullopt;
}

}  // namespace edvo
