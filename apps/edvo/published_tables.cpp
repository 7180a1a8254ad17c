// SPDX-License-Identifier: MIT
#include "published_tables.hpp"

#include "toml_file.hpp"

namespace edvo::app {
namespace {

// A number, or "-" where the system failed.
std::optional<double> read_figure(const TomlFile& file, const toml::node& node,
                                  std::string_view key) {
  if (const auto* const text = node.as_string(); text && text->get() == "-") return std::nullopt;
  const std::optional<double> figure = node.is_number() ? node.value<double>() : std::nullopt;
  if (!figure) refuse(file, node, std::string(key) + ": expected a number, or \"-\" for none");
  return figure;
}

void read_figures(const TomlFile& file, const toml::table& table, std::string_view key,
                  std::optional<double> PublishedFigures::*figure, PublishedRow& row) {
  const toml::node* const node = table.get(key);
  if (!node) return refuse(file, table, "'" + std::string(key) + "' is missing");
  const toml::array* const array = node->as_array();
  if (!array || array->size() != row.systems.size())
    return refuse(file, *node,
                  std::string(key) + ": expected a list of one figure for each of the columns");
  for (std::size_t i = 0; i < array->size(); ++i)
    row.systems[i].*figure = read_figure(file, (*array)[i], key);
}

PublishedRow read_row(const TomlFile& file, const toml::table& table, std::size_t columns) {
  check_keys(file, table, {"name", "printed", "rpe_rotation", "rpe_translation", "ate"});
  PublishedRow row{.sequence = text(file, table, "name"),
                   .printed = find_text(file, table, "printed").value_or(""),
                   .systems = std::vector<PublishedFigures>(columns)};
  read_figures(file, table, "rpe_rotation", &PublishedFigures::rpe_rotation, row);
  read_figures(file, table, "rpe_translation", &PublishedFigures::rpe_translation, row);
  read_figures(file, table, "ate", &PublishedFigures::ate, row);
  return row;
}

}  // namespace

PublishedTables read_published_tables(const std::filesystem::path& path) {
  const TomlFile file{path};
  const toml::table root = parse_toml(file);
  check_keys(file, root, {"title", "columns", "sequence"});
  PublishedTables tables{
      .title = text(file, root, "title"), .columns = texts(file, root, "columns"), .rows = {}};
  if (tables.columns.empty()) refuse(file, root, "'columns' is missing");
  for (const toml::table* table : edvo::app::tables(file, root, "sequence", "sequence"))
    tables.rows.push_back(read_row(file, *table, tables.columns.size()));
  return tables;
}

const PublishedRow* find_row(const PublishedTables& tables, std::string_view sequence) {
  for (const PublishedRow& row : tables.rows)
    if (sequence == row.sequence || sequence == row.printed) return &row;
  return nullptr;
}

}  // namespace edvo::app
