// SPDX-License-Identifier: MIT
// A benchmark in print: the two tables of a publication, a table of all systems per sequence, and
// JSON.
#pragma once

#include "bench_runs.hpp"
#include "edvo/report/table.hpp"

#include <string>

namespace edvo::app {

// Table I: relative pose errors, two lines per sequence, the published figures and ours.
[[nodiscard]] Table rpe_table(const PublishedTables& published, const BenchResult& result);

// Table II: absolute trajectory errors, likewise.
[[nodiscard]] Table ate_table(const PublishedTables& published, const BenchResult& result);

// Every system on one sequence; with_sequence adds a column that names it.
[[nodiscard]] Table systems_table(const BenchRow& row, bool with_sequence = false);

// All of them, those of a publication if the manifest names one, under their protocol, and what
// went wrong.
[[nodiscard]] std::string bench_text(const BenchManifest& manifest, const BenchResult& result,
                                     TableFormat format);

[[nodiscard]] std::string bench_json(const BenchManifest& manifest, const BenchResult& result);

}  // namespace edvo::app
