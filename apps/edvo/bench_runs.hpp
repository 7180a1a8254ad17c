// SPDX-License-Identifier: MIT
// The cells of a benchmark: runs of each system on each sequence, or what earlier ones have left.
#pragma once

#include "bench_manifest.hpp"
#include "edvo/eval/evaluate.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace edvo::app {

struct BenchOptions {
  int threads = 2;
  bool force = false;  // run also what is there already
  bool no_report = false;
  bool quiet = false;
};

// What only a run of ours can tell.
struct RunFigures {
  std::int64_t tracked = 0, lost = 0, skipped = 0;  // frames
  std::int64_t restarted = 0;                       // frames, at guessed poses
  std::int64_t lost_events = 0, keyframes = 0, segments = 0;
  double median_milliseconds = 0, p95_milliseconds = 0;  // per frame; of repeats the median
};

enum class CellKind { kMethod, kVariant, kPeer };

enum class CellState {
  kNotRun,  // a signal came before its end
  kFailed,  // could not be run, or not read
  kLost,    // ran, but no motion could be tracked
  kDone,
};

}  // namespace edvo::app

template <>
struct edvo::EnumNames<edvo::app::CellKind> {
  using Kind = app::CellKind;
  static constexpr auto names = std::to_array<std::pair<Kind, std::string_view>>({
      {Kind::kMethod, "method"},
      {Kind::kVariant, "variant"},
      {Kind::kPeer, "peer"},
  });
};

template <>
struct edvo::EnumNames<edvo::app::CellState> {
  using State = app::CellState;
  static constexpr auto names = std::to_array<std::pair<State, std::string_view>>({
      {State::kNotRun, "not run"},
      {State::kFailed, "failed"},
      {State::kLost, "lost"},
      {State::kDone, "done"},
  });
};

namespace edvo::app {

// One system on one sequence.
struct BenchCell {
  std::string name;
  CellKind kind = CellKind::kMethod;
  CellState state = CellState::kNotRun;
  std::string method;                        // empty for peers
  std::vector<std::string> set;              // of variants
  std::string config_hash;                   // empty for peers
  std::vector<std::filesystem::path> files;  // run folders, one per repeat, or the peer's file
  int reused = 0;                            // of these, left by an earlier call
  bool identical = true;                     // all repeats gave the same trajectories, bit by bit
  std::optional<RunFigures> run;             // of the first repeat, but for the times
  std::optional<Evaluation> evaluation;      // of the first repeat's final poses
  std::optional<double> live_ate;            // of its poses as known at the time [m]
  std::string problem;                       // why it is not done, or not evaluated
};

struct BenchRow {
  std::string sequence;
  std::int64_t frames = 0;  // 0 = could not be opened
  std::string ground_truth;
  std::vector<BenchCell> cells;  // systems, then peers
};

struct BenchResult {
  std::vector<BenchRow> rows;
  bool interrupted = false;
};

// Runs what has not been run with this version, configuration, camera and data. What fails is a
// cell that says so; only Error(kOutput) ends it. After a signal the cells not reached are marked.
[[nodiscard]] BenchResult run_bench(const BenchManifest& manifest, const BenchOptions& options);

}  // namespace edvo::app
