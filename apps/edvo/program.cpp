// SPDX-License-Identifier: MIT
#include "program.hpp"

#include "commands.hpp"
#include "edvo/core/error.hpp"
#include "edvo/report/machine.hpp"
#include "memory.hpp"
#include "option_checks.hpp"
#include "stop_signal.hpp"
#include "terminal.hpp"
#include "usage.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <string>
#include <vector>

namespace edvo::app {
namespace {

// What the program can do, in the order of its help. A verb is one file,
// apps/edvo/VERB_command.cpp.
void add_verbs(CLI::App& program, const Extension& extension) {
  add_run_command(program, extension);
  add_demo_command(program, extension);
  add_synth_command(program);
  add_eval_command(program);
  add_report_command(program);
  add_bench_command(program, extension);
  add_edges_command(program);
  add_models_command(program);
  add_map_command(program);
  add_config_command(program);
  add_cache_command(program);
  for (const Extension::Verb& verb : extension.verbs) add_extension_verb(program, verb);
  add_manual_commands(program);
  refuse_empty_values(program);
}

constexpr const char* kExamples = R"(Examples:
  edvo demo                                 something to look at, without any data
  edvo run rgbd_dataset_freiburg1_xyz       a folder; also a .tgz or .zip
  edvo run FOLDER --camera camera.yaml --depth-scale 1000
  edvo report RUN_A RUN_B                   runs side by side on one page
  edvo eval groundtruth.txt trajectory.tum  ATE and RPE of any system
  edvo help run                             all options of a verb)";

int fail(const Error& error) {
  say("edvo: {}\n", error.what());
  return static_cast<int>(error.code());
}

// `edvo help VERB` is `edvo VERB --help`; a verb that is unknown is left to be reported as one.
std::vector<std::string> arguments_of(const CLI::App& program, int argc, char** argv) {
  std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  if (arguments.empty() || arguments.front() != "help") return arguments;
  arguments.erase(arguments.begin());
  const auto is_meant = [&](const CLI::App* verb) { return verb->check_name(arguments.front()); };
  if (arguments.empty() || !program.get_subcommands(is_meant).empty())
    arguments.emplace_back("--help");
  return arguments;
}

void parse(CLI::App& program, std::vector<std::string> arguments) {
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  program.parse(arguments);
}

int run_verb(int argc, char** argv, const Extension& extension) {
  CLI::App program{"Edge-direct visual odometry for RGB-D cameras", "edvo"};
  program.require_subcommand(1);
  program.set_version_flag("--version", "edvo " + this_machine().edvo);
  add_verbs(program, extension);
  program.footer(kExamples);  // last: verbs take over what is there before them
  const std::vector<std::string> arguments = arguments_of(program, argc, argv);
  try {
    parse(program, arguments);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();  // the verb has said all there is to say
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    return fail(
        {ErrorCode::kUsage, explain(program, error, arguments.empty() ? "" : arguments.front())});
  }
  return 0;
}

}  // namespace

int run_program(int argc, char** argv, const Extension& extension) {
  leave_on_signals();
  keep_freed_memory();
  // What OpenCV has to say about a network arrives as an error of ours.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  try {
    const int status = run_verb(argc, argv, extension);
    finish_printing();
    return status;
  } catch (...) {
    return fail(caught_error());
  }
}

}  // namespace edvo::app
