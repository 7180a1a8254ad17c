// SPDX-License-Identifier: MIT
// Reading a TOML file of ours so that whatever is wrong in it is said with its line.
#pragma once

#include "edvo/core/toml.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo::app {

struct TomlFile {
  std::filesystem::path path;
};

// Throws Error(kConfig) "file:line: what", as all of these do.
[[noreturn]] void refuse(const TomlFile& file, const toml::node& node, const std::string& what);

[[nodiscard]] toml::table parse_toml(const TomlFile& file);

void check_keys(const TomlFile& file, const toml::table& table,
                const std::vector<std::string>& known);

// Text in quotes, not empty.
[[nodiscard]] std::string as_text(const TomlFile& file, const toml::node& node,
                                  std::string_view key);
[[nodiscard]] std::optional<std::string> find_text(const TomlFile& file, const toml::table& table,
                                                   std::string_view key);
[[nodiscard]] std::string text(const TomlFile& file, const toml::table& table,
                               std::string_view key);

// Empty if there is no such key.
[[nodiscard]] std::vector<std::string> texts(const TomlFile& file, const toml::table& table,
                                             std::string_view key);
[[nodiscard]] std::vector<const toml::table*> tables(const TomlFile& file,
                                                     const toml::table& parent,
                                                     std::string_view key,
                                                     std::string_view heading);

}  // namespace edvo::app
