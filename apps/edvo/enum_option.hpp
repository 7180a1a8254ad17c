// SPDX-License-Identifier: MIT
// Enums as words of the command line and of files.
#pragma once

#include "edvo/core/fields.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo::app {

template <typename Enum>
[[nodiscard]] std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const auto& [value, name] : EnumNames<Enum>::names) names.emplace_back(name);
  return names;
}

template <typename Enum>
[[nodiscard]] std::optional<Enum> find_named(std::string_view wanted) {
  for (const auto& [value, name] : EnumNames<Enum>::names)
    if (name == wanted) return value;
  return std::nullopt;
}

}  // namespace edvo::app
