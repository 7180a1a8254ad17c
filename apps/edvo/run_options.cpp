// SPDX-License-Identifier: MIT
#include "run_options.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"

#include <fmt/format.h>

namespace edvo::app {
namespace {

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const auto& [method, name] : EnumNames<Method>::names) names.emplace_back(name);
  return names;
}

Method method_named(const std::string& wanted) {
  for (const auto& [method, name] : EnumNames<Method>::names)
    if (name == wanted) return method;
  const std::vector<std::string> names = method_names();
  throw Error(ErrorCode::kUsage, fmt::format("--method {}: no such method{}; there are {}", wanted,
                                             did_you_mean(wanted, names), fmt::join(names, ", ")));
}

}  // namespace

void add_run_options(CLI::App& command, RunOptions& options) {
  constexpr int kMostThreads = 256;
  command
      .add_option("--method", options.method,
                  fmt::format("One of {}", fmt::join(method_names(), ", ")))
      ->type_name("NAME")
      ->capture_default_str();
  command
      .add_option("--config", options.config_file, "Options to put over the method's own (TOML)")
      ->type_name("FILE");
  command
      .add_option("--set", options.assignments,
                  "One option, over those of the file; may be repeated (see `edvo config`)")
      ->type_name("GROUP.FIELD=VALUE")
      ->allow_extra_args(false);
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

Config resolve_config(const RunOptions& options) {
  Config config = preset(method_named(options.method));
  if (!options.config_file.empty())
    config = config_from_toml(read_file(options.config_file), options.config_file, config);
  for (const std::string& assignment : options.assignments) set_option(config, assignment);
  check(config);
  return config;
}

}  // namespace edvo::app
