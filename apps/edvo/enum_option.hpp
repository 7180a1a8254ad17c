// SPDX-License-Identifier: MIT
// Enums as words of the command line and of files.
#pragma once

#include "edvo/core/find_named.hpp"

#include <string>
#include <vector>

namespace edvo::app {

template <typename Enum>
[[nodiscard]] std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const auto& [value, name] : EnumNames<Enum>::names) names.emplace_back(name);
  return names;
}

}  // namespace edvo::app
