// SPDX-License-Identifier: MIT
// Public edge networks that edvo knows how to use, and where they can be downloaded.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace edvo {

struct KnownModel {
  std::string_view name;
  std::span<const std::string_view> addresses;  // the best first
  std::int64_t bytes = 0;
  std::string_view sha256;
  std::string_view licence;
  std::string_view source;  // who made it, and from what
  std::string_view usage;   // the sections input and output of its description, TOML
};

[[nodiscard]] std::span<const KnownModel> known_models();

// Null if there is no known model of that name.
[[nodiscard]] const KnownModel* find_known_model(std::string_view name);

}  // namespace edvo
