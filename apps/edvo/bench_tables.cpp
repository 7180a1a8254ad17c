// SPDX-License-Identifier: MIT
#include "bench_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>

namespace edvo::app {
namespace {

constexpr const char* kMissing = "-";

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// The system of ours, or the peer, that stands in a column of the paper; null if there is none.
const BenchCell* find_cell(const BenchRow& row, std::string_view column) {
  for (const BenchCell& cell : row.cells)
    if (cell.kind != CellKind::kVariant && lower(cell.name) == lower(column)) return &cell;
  return nullptr;
}

std::string figure(const std::optional<double>& value) {
  return value ? fmt::format("{:.6f}", *value) : kMissing;  // as many decimals as the paper
}

// A cell without figures says why in a word, once.
std::string word(const BenchCell* cell) {
  return cell && cell->state != CellState::kDone ? std::string(name_of(cell->state)) : kMissing;
}

std::optional<double> rpe_of(const BenchCell* cell, Statistics Rpe::*part) {
  if (!cell || !cell->evaluation || !cell->evaluation->rpe) return std::nullopt;
  return ((*cell->evaluation->rpe).*part).rmse;
}

std::optional<double> ate_of(const BenchCell* cell) {
  if (!cell || !cell->evaluation) return std::nullopt;
  return cell->evaluation->ate.distance.rmse;
}

std::string figure_or_word(const std::optional<double>& value, const BenchCell* cell) {
  return value ? figure(value) : word(cell);
}

// add(row of the table, paper's figures) and add(row of the table, our cell) for each column.
template <typename AddPaper, typename AddOurs>
void add_rows(Table& table, const PublishedTables& published, const BenchResult& result,
              AddPaper add_paper, AddOurs add_ours) {
  for (const BenchRow& row : result.rows) {
    if (const PublishedRow* paper = find_row(published, row.sequence)) {
      table.rows.push_back({row.sequence + ", paper"});
      for (const PublishedFigures& figures : paper->systems) add_paper(table.rows.back(), figures);
    }
    table.rows.push_back({row.sequence + ", measured"});
    for (const std::string& column : published.columns)
      add_ours(table.rows.back(), find_cell(row, column));
  }
}

std::string label(const BenchCell& cell) {
  return cell.kind == CellKind::kVariant ? fmt::format("{}, {}", cell.method, cell.name)
                                         : cell.name;
}

std::vector<std::string> system_row(const BenchCell& cell) {
  const auto counted = [](bool known, auto value, int decimals) {
    return known ? fmt::format("{:.{}f}", static_cast<double>(value), decimals)
                 : std::string(kMissing);
  };
  const bool is_evaluated = cell.evaluation.has_value();
  const Evaluation evaluation = cell.evaluation.value_or(Evaluation{});
  const bool has_run = cell.run.has_value();
  const RunFigures run = cell.run.value_or(RunFigures{});
  return {
      label(cell),
      figure_or_word(ate_of(&cell), &cell),
      figure(cell.live_ate),
      figure(rpe_of(&cell, &Rpe::translation)),
      figure(rpe_of(&cell, &Rpe::rotation)),
      counted(is_evaluated, evaluation.matches.size(), 0),
      counted(is_evaluated, 100 * evaluation.coverage, 1),
      counted(is_evaluated && evaluation.drift.percent, evaluation.drift.percent.value_or(0), 2),
      counted(has_run, run.keyframes, 0),
      counted(has_run, run.lost_events, 0),
      counted(has_run, run.segments, 0),
      counted(has_run, run.median_milliseconds, 1),
      counted(has_run, run.p95_milliseconds, 1)};
}

Table joined_systems(const BenchResult& result) {
  Table all;
  for (const BenchRow& row : result.rows) {
    Table table = systems_table(row, true);
    all.header = table.header;
    all.rows.insert(all.rows.end(), table.rows.begin(), table.rows.end());
  }
  return all;
}

std::string systems_text(const BenchResult& result, TableFormat format) {
  if (format == TableFormat::kCsv)
    return format_note("All systems", format) + format_table(joined_systems(result), format);
  std::string text;
  for (const BenchRow& row : result.rows) {
    const std::string frames =
        row.frames > 0 ? fmt::format("{} frames", row.frames) : "could not be opened";
    text += format_note(fmt::format("All systems on {}, {}", row.sequence, frames), format) +
            format_table(systems_table(row), format);
    if (format == TableFormat::kText) text += '\n';
  }
  return text;
}

std::string repeats_line(const BenchManifest& manifest, const BenchResult& result) {
  if (manifest.repeats == 1) return "each run once";
  for (const BenchRow& row : result.rows)
    for (const BenchCell& cell : row.cells)
      if (!cell.identical)
        return fmt::format("{} runs each; NOT all gave the same trajectories", manifest.repeats);
  return fmt::format("{} runs each, with the same trajectories to the last bit; times are medians",
                     manifest.repeats);
}

std::string problem_line(const BenchRow& row, const BenchCell& cell) {
  if (row.frames == 0 && cell.state == CellState::kFailed)
    return fmt::format("{}: {}", row.sequence, cell.problem);
  return fmt::format("{}, {}: {}: {}", row.sequence, label(cell),
                     cell.state == CellState::kDone ? "not evaluated" : name_of(cell.state),
                     cell.problem);
}

// What all cells of a sequence have in common is said once.
std::string problems_text(const BenchResult& result, TableFormat format) {
  std::string text, previous;
  for (const BenchRow& row : result.rows)
    for (const BenchCell& cell : row.cells) {
      if (cell.problem.empty()) continue;
      const std::string line = problem_line(row, cell);
      if (line != previous) text += format_note(line, format);
      previous = line;
    }
  return text;
}

}  // namespace

Table rpe_table(const PublishedTables& published, const BenchResult& result) {
  Table table{.header = {"sequence"}, .rows = {}};
  for (const std::string& column : published.columns)
    for (const char* part : {"R", "T"}) table.header.push_back(fmt::format("{} {}", column, part));
  add_rows(
      table, published, result,
      [](std::vector<std::string>& row, const PublishedFigures& figures) {
        row.push_back(figure(figures.rpe_rotation));
        row.push_back(figure(figures.rpe_translation));
      },
      [](std::vector<std::string>& row, const BenchCell* cell) {
        row.push_back(figure_or_word(rpe_of(cell, &Rpe::rotation), cell));
        row.push_back(figure_or_word(rpe_of(cell, &Rpe::translation), cell));
      });
  return table;
}

Table ate_table(const PublishedTables& published, const BenchResult& result) {
  Table table{.header = {"sequence"}, .rows = {}};
  for (const std::string& column : published.columns) table.header.emplace_back(column);
  add_rows(
      table, published, result,
      [](std::vector<std::string>& row, const PublishedFigures& figures) {
        row.push_back(figure(figures.ate));
      },
      [](std::vector<std::string>& row, const BenchCell* cell) {
        row.push_back(figure_or_word(ate_of(cell), cell));
      });
  return table;
}

Table systems_table(const BenchRow& row, bool with_sequence) {
  Table table{.header = {"system", "ATE [m]", "live ATE [m]", "RPE [m/s]", "RPE [deg/s]", "pairs",
                         "coverage [%]", "drift [%]", "keyframes", "lost events", "segments", "ms",
                         "ms p95"},
              .rows = {}};
  for (const BenchCell& cell : row.cells) table.rows.push_back(system_row(cell));
  if (!with_sequence) return table;
  table.header.insert(table.header.begin(), "sequence");
  for (std::vector<std::string>& cells : table.rows) cells.insert(cells.begin(), row.sequence);
  return table;
}

std::string bench_text(const BenchManifest& manifest, const BenchResult& result,
                       TableFormat format) {
  const std::string gap = format == TableFormat::kText ? "\n" : "";
  std::string text;
  if (manifest.published)
    text +=
        format_note("Table I: relative pose error, root mean square (R: deg/s, T: m/s)", format) +
        format_table(rpe_table(*manifest.published, result), format) + gap +
        format_note("Table II: absolute trajectory error, root mean square [m]", format) +
        format_table(ate_table(*manifest.published, result), format) + gap;
  text += systems_text(result, format);
  if (manifest.published) text += format_note("paper: " + manifest.published->title, format);
  return text + format_note("measured: " + describe_protocol({}), format) +
         format_note(repeats_line(manifest, result), format) + problems_text(result, format);
}

}  // namespace edvo::app
