// SPDX-License-Identifier: MIT
// Figures that a publication prints, to stand beside measured ones: a file of data beside the
// manifest (benchmarks/paper_tables.toml).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo::app {

// Root mean squares; none where the system failed.
struct PublishedFigures {
  std::optional<double> rpe_rotation;     // [deg/s]
  std::optional<double> rpe_translation;  // [m/s]
  std::optional<double> ate;              // [m]
};

struct PublishedRow {
  std::string sequence;                   // as manifests name it
  std::string printed;                    // as the publication does
  std::vector<PublishedFigures> systems;  // in the order of the columns
};

struct PublishedTables {
  std::string title;
  std::vector<std::string> columns;  // systems
  std::vector<PublishedRow> rows;
};

// Throws Error(kConfig) "file:line: ..." at what is missing, unknown or not a figure.
[[nodiscard]] PublishedTables read_published_tables(const std::filesystem::path& file);

// By either of its names; null if the publication has no such sequence.
[[nodiscard]] const PublishedRow* find_row(const PublishedTables& tables,
                                           std::string_view sequence);

}  // namespace edvo::app
