// SPDX-License-Identifier: MIT
// The flags of every verb that takes a configuration: --method, --config, --model, --set.
#pragma once

#include "edvo/odometry/config.hpp"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace edvo::app {

struct ConfigFlags {
  std::string method;            // empty = the default method
  std::string file;              // TOML, empty = none
  std::string model;             // description of a network, empty = none
  std::vector<std::string> set;  // "group.field=value", applied last
};

void add_config_flags(CLI::App& verb, ConfigFlags& flags);

// The method asked for. A model asks for a method that uses it; nothing said is the default.
[[nodiscard]] Method chosen_method(const ConfigFlags& flags);

// The method's preset, then the file, the model and each --set, in this order; checked.
[[nodiscard]] Config resolve_config(const ConfigFlags& flags);

}  // namespace edvo::app
