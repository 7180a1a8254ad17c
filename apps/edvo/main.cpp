// SPDX-License-Identifier: MIT
#include "commands.hpp"
#include "edvo/core/error.hpp"

#include <fmt/core.h>

namespace {

// What the program can do, in the order of its help. A verb is one file,
// apps/edvo/VERB_command.cpp.
const std::vector<void (*)(CLI::App&)> kVerbs = {
    edvo::app::add_run_command,
    edvo::app::add_eval_command,
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{"Edge-direct visual odometry for RGB-D cameras", "edvo"};
  program.require_subcommand(1);
  for (const auto add : kVerbs) add(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::RuntimeError& error) {
    return error.get_exit_code();  // the verb has said all there is to say
  } catch (const CLI::ParseError& error) {
    const int code = program.exit(error);
    return code == 0 ? 0 : static_cast<int>(edvo::ErrorCode::kUsage);
  } catch (const edvo::Error& error) {
    fmt::print(stderr, "edvo: {}\n", error.what());
    return static_cast<int>(error.code());
  }
  return 0;
}
