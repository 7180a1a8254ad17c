// SPDX-License-Identifier: MIT
#include "run_options.hpp"

namespace edvo::app {

void add_run_options(CLI::App& command, RunOptions& options) {
  constexpr int kMostThreads = 256;
  add_config_flags(command, options.config);
  command
      .add_option("-o,--output", options.output,
                  "Folder for the results, default runs/<sequence>/<UTC time>")
      ->type_name("DIR");
  command.add_flag("--force", options.force, "Replace the results of an earlier run in DIR");
  command.add_option("--threads", options.threads, "1, or more to read images ahead of their use")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  command.add_flag("--json", options.json, "Print the summary as one JSON object");
  command.add_flag("--no-report", options.no_report, "Do not write report.html");
  command.add_flag("--quiet", options.quiet, "No notes and no progress; warnings stay");
  command.add_flag("--profile", options.profile, "Print where the time went, stage by stage");
}

std::string method_name(const RunOptions& options) {
  return std::string(name_of(chosen_method(options.config)));
}

}  // namespace edvo::app
