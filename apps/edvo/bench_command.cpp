// SPDX-License-Identifier: MIT
// edvo bench MANIFEST
#include "bench_manifest.hpp"
#include "bench_runs.hpp"
#include "bench_tables.hpp"
#include "commands.hpp"
#include "edvo/core/error.hpp"
#include "enum_option.hpp"
#include "stop_signal.hpp"
#include "terminal.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <memory>

namespace edvo::app {
namespace {

struct Arguments {
  std::string manifest;
  std::string output;  // empty = as the manifest says
  std::string data;
  int repeats = 0;              // 0 = as the manifest says
  std::int64_t max_frames = 0;  // 0 = as the manifest says
  bool no_peers = false;
  std::string format = "text";
  bool json = false;
  BenchOptions run;
};

// What could not be done is in the tables; the status says it to scripts.
int status_of(const BenchResult& result) {
  if (result.interrupted) return kInterruptedStatus;
  for (const BenchRow& row : result.rows)
    for (const BenchCell& cell : row.cells)
      if (cell.state != CellState::kDone) return static_cast<int>(ErrorCode::kTrackingLost);
  return 0;
}

void bench(const Arguments& arguments, const Extension& extension) {
  BenchManifest manifest = read_manifest(
      arguments.manifest,
      {.data = arguments.data, .with_peers = !arguments.no_peers, .pull = extension.pull});
  if (!arguments.output.empty()) manifest.output = arguments.output;
  if (arguments.repeats > 0) manifest.repeats = arguments.repeats;
  if (arguments.max_frames > 0)
    for (BenchSequence& sequence : manifest.sequences)
      sequence.choice.max_frames = arguments.max_frames;
  for (const std::string& warning : manifest.warnings) say("warning: {}\n", warning);

  const BenchResult result = run_bench(manifest, arguments.run);
  const bool is_json = arguments.json || arguments.format == "json";
  print("{}",
        is_json ? bench_json(manifest, result)
                : bench_text(manifest, result, find_named<TableFormat>(arguments.format).value()));
  if (const int status = status_of(result); status != 0) throw CLI::RuntimeError("", status);
}

}  // namespace

void add_bench_command(CLI::App& program, const Extension& extension) {
  constexpr int kMostRepeats = 1000, kMostThreads = 256;
  constexpr std::int64_t kMostFrames = 1'000'000'000;
  const auto arguments = std::make_shared<Arguments>();
  BenchOptions& run = arguments->run;
  std::vector<std::string> formats = names_of<TableFormat>();
  formats.emplace_back("json");

  CLI::App* command = program.add_subcommand(
      "bench", "Run sequences x methods and print the paper's tables with measured figures");
  command->add_option("manifest", arguments->manifest, "What to run (docs/evaluation.md)")
      ->required()
      ->type_name("MANIFEST");
  command
      ->add_option("-o,--output", arguments->output,
                   "Folder of the runs, default as in the manifest or bench/<its name>")
      ->type_name("DIR");
  command
      ->add_option("--data", arguments->data,
                   "Where the manifest's paths of data start, default its own folder")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
  command->add_option("--repeats", arguments->repeats, "Runs of each, default as in the manifest")
      ->type_name("N")
      ->check(CLI::Range(1, kMostRepeats));
  command
      ->add_option("--max-frames", arguments->max_frames,
                   "Frames of each sequence at most, default as in the manifest")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{1}, kMostFrames));
  command->add_flag("--no-peers", arguments->no_peers,
                    "Leave out the trajectories of other systems");
  command->add_option("--threads", run.threads, "1, or more to read images ahead of their use")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  command->add_flag("--force", run.force, "Run again what earlier calls have left");
  command->add_flag("--no-report", run.no_report, "Do not write report.html");
  command->add_flag("--quiet", run.quiet, "No progress; warnings stay");
  command->add_option("--format", arguments->format, "What to print")
      ->check(CLI::IsMember(formats))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Same as --format json");
  command->callback([arguments, &extension] { bench(*arguments, extension); });
}

}  // namespace edvo::app
