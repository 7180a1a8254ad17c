// SPDX-License-Identifier: MIT
// edvo config: prints the options that the same flags would give to another verb.
#include "commands.hpp"
#include "config_flags.hpp"
#include "terminal.hpp"

#include <fmt/core.h>

#include <memory>

namespace edvo::app {

void add_config_command(CLI::App& program) {
  CLI::App* verb = program.add_subcommand("config", "Print the resolved options as TOML");
  const auto flags = std::make_shared<ConfigFlags>();
  add_config_flags(*verb, *flags);
  verb->callback([flags] { print("{}", to_toml(resolve_config(*flags))); });
}

}  // namespace edvo::app
