// SPDX-License-Identifier: MIT
#include "toml_file.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/error.hpp"
#include "edvo/core/parse_toml.hpp"
#include "edvo/io/file.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace edvo::app {

void refuse(const TomlFile& file, const toml::node& node, const std::string& what) {
  throw Error(ErrorCode::kConfig,
              fmt::format("{}:{}: {}", file.path.string(), node.source().begin.line, what));
}

toml::table parse_toml(const TomlFile& file) {
  constexpr std::size_t kLargestFile = 1 << 24;  // [bytes]
  return edvo::parse_toml(read_file(file.path, kLargestFile), file.path.string(),
                          ErrorCode::kConfig);
}

void check_keys(const TomlFile& file, const toml::table& table,
                const std::vector<std::string>& known) {
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) == known.end())
      refuse(file, node,
             fmt::format("unknown key '{}'{} (known: {})", name, did_you_mean(name, known),
                         fmt::join(known, ", ")));
  }
}

std::string as_text(const TomlFile& file, const toml::node& node, std::string_view key) {
  const auto* const text = node.as_string();
  if (!text || text->get().empty())
    refuse(file, node, fmt::format("{}: expected text in quotes, not empty", key));
  return text->get();
}

std::optional<std::string> find_text(const TomlFile& file, const toml::table& table,
                                     std::string_view key) {
  const toml::node* const node = table.get(key);
  if (!node) return std::nullopt;
  return as_text(file, *node, key);
}

std::string text(const TomlFile& file, const toml::table& table, std::string_view key) {
  const std::optional<std::string> value = find_text(file, table, key);
  if (!value) refuse(file, table, fmt::format("'{}' is missing", key));
  return *value;
}

std::vector<std::string> texts(const TomlFile& file, const toml::table& table,
                               std::string_view key) {
  const toml::node* const node = table.get(key);
  if (!node) return {};
  const toml::array* const array = node->as_array();
  if (!array) refuse(file, *node, fmt::format(R"({}: expected a list, ["...", "..."])", key));
  std::vector<std::string> values;
  for (const toml::node& item : *array) values.push_back(as_text(file, item, key));
  return values;
}

std::vector<const toml::table*> tables(const TomlFile& file, const toml::table& parent,
                                       std::string_view key, std::string_view heading) {
  const toml::node* const node = parent.get(key);
  if (!node) return {};
  const toml::array* const array = node->as_array();
  if (!array) refuse(file, *node, fmt::format("{}: expected [[{}]]", key, heading));
  std::vector<const toml::table*> found;
  for (const toml::node& item : *array) {
    if (!item.is_table()) refuse(file, item, fmt::format("{}: expected [[{}]]", key, heading));
    found.push_back(item.as_table());
  }
  return found;
}

}  // namespace edvo::app
