// SPDX-License-Identifier: MIT
#include "bench_runs.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/nesting.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/report/run_folder.hpp"
#include "recorded_run.hpp"
#include "sequence_input.hpp"
#include "stop_signal.hpp"
#include "terminal.hpp"

#include <fmt/core.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <nlohmann/json.hpp>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::string_view kInterrupted = "interrupted; the same command goes on from here";

// Everything that a cell of a sequence needs.
struct Sequence {
  const BenchSequence& choice;
  FolderSource& source;
  std::string input;  // fingerprint()
  std::optional<GroundTruth> truth;
  EvalOptions options;
};

// --- one run ------------------------------------------------------------------------------------

// The parts of a summary that must be the same for a run to stand for another.
Json identity(const Json& summary) {
  Json parts;
  for (const char* key : {"schema_version", "edvo_version", "source", "config_hash", "camera",
                          "depth", "interrupted"})
    parts[key] = summary.value(key, Json());
  parts["frames"] = summary.value("frames", Json::object()).value("total", Json());
  return parts;
}

constexpr std::string_view kInputFile = "bench_input.txt";  // beside the summary

// Tells images that were changed under the same names: by their names, sizes and times, as reading
// all of them would take as long as tracking them.
std::string fingerprint(const FolderSource& source, std::int64_t first) {
  const std::vector<FrameEntry>& frames = source.dataset().frames;
  const auto end = static_cast<std::size_t>(first + source.info().frames.value());
  std::string all;
  for (std::size_t i = static_cast<std::size_t>(first); i < end; ++i) {
    all += to_string(frames.at(i).stamp);
    for (const fs::path& file : {frames.at(i).colour, frames.at(i).depth}) {
      std::error_code ignored;
      const auto changed = fs::last_write_time(file, ignored).time_since_epoch().count();
      all += fmt::format(" {} {} {}", file.string(), fs::file_size(file, ignored), changed);
    }
    all += '\n';
  }
  return sha256(all);
}

bool is_of(const fs::path& folder, const std::string& input) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kInputFile, ignored) &&
         read_file(folder / kInputFile) == input + '\n';
}

// The summary of an earlier run that is what this one would be.
std::optional<Json> find_earlier(const fs::path& folder, const RunDescription& description,
                                 const std::string& input) {
  const fs::path file = folder / "summary.json";
  std::error_code error;
  if (!fs::exists(file, error) || !is_of(folder, input)) return std::nullopt;
  const std::string text = read_file(file);
  if (line_nested_too_deeply_in_json(text)) return std::nullopt;
  const Json summary = Json::parse(text, nullptr, false);
  if (!summary.is_object()) return std::nullopt;
  const Json wanted = Json::parse(to_json(summarize(description, {}, {})));
  if (identity(summary) != identity(wanted)) return std::nullopt;
  return summary;
}

// Runs, and gives back the summary as it is on disk. Nothing but runs is ever replaced.
Json run_anew(const fs::path& folder, const BenchSystem& system, const RunDescription& description,
              const Sequence& sequence, const BenchOptions& options) {
  RunFlags run;
  run.output = folder.string();
  run.force = fs::exists(folder / "frames.jsonl");
  run.threads = options.threads;
  run.no_report = options.no_report;
  run.quiet = options.quiet || isatty(STDERR_FILENO) == 0;
  sequence.source.rewind();
  const RecordedRun result =
      record_run(sequence.source, description, system.config, run, sequence.truth);
  if (result.failure && result.failure->code() != ErrorCode::kTrackingLost)
    throw Error(*result.failure);
  write_whole(folder / kInputFile, sequence.input + '\n');
  return Json::parse(read_file(folder / "summary.json"));
}

RunFigures figures_of(const Json& summary) {
  const Json& frames = summary.at("frames");
  const Json& total = summary.at("ms").at("total");
  return {.tracked = frames.at("tracked"),
          .lost = frames.at("lost"),
          .skipped = frames.at("skipped"),
          .restarted = frames.at("restarted"),
          .lost_events = summary.at("lost_events"),
          .keyframes = summary.at("keyframes"),
          .segments = summary.at("segments"),
          .median_milliseconds = total.at("median"),
          .p95_milliseconds = total.at("p95")};
}

// True if both runs say the same, to the last bit that they write.
bool same_poses(const fs::path& a, const fs::path& b) {
  for (const char* name : {"trajectory.tum", "trajectory_online.tum"})
    if (read_file(a / name) != read_file(b / name)) return false;
  return true;
}

// --- one cell -----------------------------------------------------------------------------------

// None, and a problem, where the two cannot be compared.
std::optional<Evaluation> try_to_evaluate(const std::optional<GroundTruth>& truth,
                                          const Trajectory& estimate, const EvalOptions& options,
                                          std::string& problem) {
  if (!truth) {
    problem = "no ground truth";
    return std::nullopt;
  }
  try {
    return evaluate(truth->trajectory, estimate, options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kEvaluation) throw;
    problem = error.what();
    return std::nullopt;
  }
}

void evaluate_first_repeat(const Sequence& sequence, BenchCell& cell) {
  if (cell.run->tracked <= 1) {
    cell.state = CellState::kLost;
    const RunFigures& run = *cell.run;
    const auto frames = run.tracked + run.restarted + run.lost + run.skipped;
    cell.problem = frames == 1 && run.tracked == 1
                       ? "one frame has no motion to track"
                       : fmt::format("tracking lost: {} lost and {} skipped of {} frames", run.lost,
                                     run.skipped, frames);
    return;
  }
  cell.state = CellState::kDone;
  const fs::path& folder = cell.files.front();
  const Trajectory final_poses = read_trajectory(folder / "trajectory.tum").trajectory;
  cell.evaluation = try_to_evaluate(sequence.truth, final_poses, sequence.options, cell.problem);
  if (!cell.evaluation) return;
  const Trajectory live = read_trajectory(folder / "trajectory_online.tum").trajectory;
  std::string ignored;
  if (const auto live_evaluation = try_to_evaluate(sequence.truth, live, sequence.options, ignored))
    cell.live_ate = live_evaluation->ate.distance.rmse;
}

BenchCell empty_cell(const BenchSystem& system) {
  BenchCell cell;
  cell.name = system.name;
  cell.kind = system.set.empty() ? CellKind::kMethod : CellKind::kVariant;
  cell.method = system.method;
  cell.set = system.set;
  cell.config_hash = config_hash(to_toml(system.config));
  return cell;
}

void run_repeats(const BenchManifest& manifest, const BenchOptions& options,
                 const Sequence& sequence, const BenchSystem& system, BenchCell& cell) {
  const std::string method = cell.kind == CellKind::kVariant
                                 ? fmt::format("{}: {}", system.method, system.name)
                                 : system.method;
  const RunDescription description = describe_run(sequence.source.info(), method, system.config);
  std::vector<double> medians, p95s;
  for (int repeat = 1; repeat <= manifest.repeats; ++repeat) {
    const fs::path folder = manifest.output / folder_name(sequence.choice.name) /
                            folder_name(system.name) / std::to_string(repeat);
    const std::optional<Json> earlier =

        options.force ? std::nullopt : find_earlier(folder, description, sequence.input);
    const Json summary =
        earlier ? *earlier : run_anew(folder, system, description, sequence, options);
    if (summary.at("interrupted").get<bool>()) {
      cell.problem = kInterrupted;
      return;
    }
    const RunFigures figures = figures_of(summary);
    if (repeat == 1) cell.run = figures;
    cell.files.push_back(folder);
    cell.reused += earlier ? 1 : 0;
    cell.identical = cell.identical && same_poses(cell.files.front(), folder);
    medians.push_back(figures.median_milliseconds);
    p95s.push_back(figures.p95_milliseconds);
  }
  cell.run->median_milliseconds = median(medians);
  cell.run->p95_milliseconds = median(p95s);
  evaluate_first_repeat(sequence, cell);
}

BenchCell run_cell(const BenchManifest& manifest, const BenchOptions& options,
                   const Sequence& sequence, const BenchSystem& system) {
  BenchCell cell = empty_cell(system);
  try {
    run_repeats(manifest, options, sequence, system, cell);
  } catch (const CLI::Error&) {
    throw;  // the end of the program, not of a run
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kOutput) throw;
    cell.state = CellState::kFailed;
    cell.problem = error.what();
  } catch (const std::exception& error) {
    cell.state = CellState::kFailed;
    cell.problem = error.what();
  }
  return cell;
}

// The frames that are compared, by their stamps; a peer's may be written with other digits.
struct Span {
  Stamp first, last;
};

Span span_of(const FolderSource& source, std::int64_t first) {
  const std::vector<FrameEntry>& frames = source.dataset().frames;
  const std::int64_t last = first + source.info().frames.value() - 1;
  return {frames.at(static_cast<std::size_t>(first)).stamp,
          frames.at(static_cast<std::size_t>(last)).stamp};
}

// The poses of a peer that has run on more frames than were asked for.
Trajectory within(const Trajectory& trajectory, const Span& span) {
  constexpr double kTolerance = 1e-3;  // [s]
  Trajectory part;
  for (const StampedPose& pose : trajectory)
    if (seconds_between(span.first, pose.stamp) >= -kTolerance &&
        seconds_between(pose.stamp, span.last) >= -kTolerance)
      part.push_back(pose);
  return part;
}

BenchCell peer_cell(const BenchPeer& peer, const std::optional<GroundTruth>& truth,
                    const EvalOptions& options, const std::optional<Span>& span) {
  BenchCell cell;
  cell.name = peer.name;
  cell.kind = CellKind::kPeer;
  cell.files = {peer.file};
  cell.state = CellState::kDone;
  cell.evaluation = try_to_evaluate(truth, span ? within(peer.trajectory, *span) : peer.trajectory,
                                    options, cell.problem);
  return cell;
}

// --- what is said on the way --------------------------------------------------------------------

std::string outcome_of(const BenchCell& cell) {
  if (!cell.problem.empty()) return cell.problem;
  return fmt::format("ATE {:.4f} m, {:.1f} ms per frame{}", cell.evaluation->ate.distance.rmse,
                     cell.run->median_milliseconds, cell.reused > 0 ? ", from an earlier run" : "");
}

struct Talk {
  bool quiet = false;
  std::size_t cells = 0, done = 0;

  void begin(const std::string& sequence, const std::string& system) {
    ++done;
    if (!quiet) say("[{}/{}] {}, {}\n", done, cells, sequence, system);
  }
  void end(const BenchCell& cell) const {
    if (!quiet) say("  {}\n", outcome_of(cell));
    if (!cell.identical) say("warning: {}: repeats gave different trajectories\n", cell.name);
  }
  static void warn(const std::string& sequence, const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) say("warning: {}: {}\n", sequence, warning);
  }
};

// --- one sequence -------------------------------------------------------------------------------

Sequence with_truth(const BenchSequence& choice, FolderSource& source) {
  const SourceInfo& info = source.info();
  Talk::warn(choice.name, info.warnings);
  return {.choice = choice,
          .source = source,
          .input = fingerprint(source, choice.choice.first),
          .truth = choice.truth ? choice.truth : info.ground_truth,
          .options = {.frames = static_cast<int>(info.frames.value())}};
}

void run_systems(const BenchManifest& manifest, const BenchOptions& options,
                 const Sequence& sequence, Talk& talk, BenchRow& row, bool& interrupted) {
  for (const BenchSystem& system : manifest.systems) {
    talk.begin(row.sequence, system.name);
    row.cells.push_back(run_cell(manifest, options, sequence, system));
    talk.end(row.cells.back());
    interrupted = row.cells.back().state == CellState::kNotRun;
    if (interrupted) return;
  }
}

BenchRow run_row(const BenchManifest& manifest, const BenchOptions& options,
                 const BenchSequence& choice, Talk& talk, bool& interrupted) {
  BenchRow row{.sequence = choice.name, .cells = {}};
  std::optional<GroundTruth> truth = choice.truth;
  EvalOptions evaluation;
  std::optional<Span> span;  // unknown where the sequence cannot be opened
  CellState state = CellState::kNotRun;
  std::string problem(kInterrupted);
  try {
    if (!interrupted) {
      FolderSource source = open_sequence(choice.choice, options.quiet);
      const Sequence sequence = with_truth(choice, source);
      truth = sequence.truth;
      evaluation = sequence.options;
      span = span_of(source, choice.choice.first);
      row.frames = evaluation.frames;
      run_systems(manifest, options, sequence, talk, row, interrupted);
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kOutput) throw;
    state = CellState::kFailed;
    problem = error.what();
    Talk::warn(choice.name, {problem});
  }
  for (std::size_t i = row.cells.size(); i < manifest.systems.size(); ++i) {
    row.cells.push_back(empty_cell(manifest.systems[i]));
    row.cells.back().state = state;
    row.cells.back().problem = problem;
    ++talk.done;
  }
  if (truth) row.ground_truth = truth->source;
  for (const BenchPeer& peer : choice.peers)
    row.cells.push_back(peer_cell(peer, truth, evaluation, span));
  return row;
}

}  // namespace

BenchResult run_bench(const BenchManifest& manifest, const BenchOptions& options) {
  BenchResult result;
  Talk talk{.quiet = options.quiet, .cells = manifest.sequences.size() * manifest.systems.size()};
  for (const BenchSequence& sequence : manifest.sequences)
    result.rows.push_back(run_row(manifest, options, sequence, talk, result.interrupted));
  return result;
}

}  // namespace edvo::app
