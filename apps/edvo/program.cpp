// SPDX-License-Identifier: MIT
#include "program.hpp"

#include "commands.hpp"
#include "edvo/core/error.hpp"
#include "memory.hpp"
#include "usage.hpp"

#include <fmt/core.h>

#include <opencv2/core/utils/logger.hpp>

namespace edvo::app {
namespace {

// What the program can do, in the order of its help. A verb is one file,
// apps/edvo/VERB_command.cpp.
const std::vector<void (*)(CLI::App&)> kVerbs = {
    add_run_command,   add_demo_command,  add_synth_command,  add_eval_command,
    add_bench_command, add_edges_command, add_models_command, add_config_command,
};

int fail(ErrorCode code, const std::string& message) {
  fmt::print(stderr, "edvo: {}\n", message);
  return static_cast<int>(code);
}

}  // namespace

int run_program(int argc, char** argv) {
  keep_freed_memory();
  // What OpenCV has to say about a network arrives as an error of ours.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  CLI::App program{"Edge-direct visual odometry for RGB-D cameras", "edvo"};
  program.require_subcommand(1);
  for (const auto add : kVerbs) add(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();  // the verb has said all there is to say
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    return fail(ErrorCode::kUsage, explain(program, error, argc > 1 ? argv[1] : ""));
  } catch (const Error& error) {
    return fail(error.code(), error.what());
  } catch (const std::exception& error) {
    return fail(ErrorCode::kInternal, error.what());
  }
  return 0;
}

}  // namespace edvo::app
