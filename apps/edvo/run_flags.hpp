// SPDX-License-Identifier: MIT
// What `edvo run` and `edvo demo` share on the command line.
#pragma once

#include "config_flags.hpp"

#include <CLI/CLI.hpp>

#include <string>

namespace edvo::app {

struct RunFlags {
  ConfigFlags config;
  std::string output;      // folder, empty = runs/<sequence>/<UTC stamp>
  std::string edge_cache;  // folder, empty = none
  std::string points;      // PLY file, empty = none
  std::string map;         // file of an earlier map, empty = none
  std::string save_map;    // file, empty = none
  bool update_map = false;
  bool force = false;
  bool no_loops = false;
  bool no_final_pass = false;
  int threads = 2;  // one of them reads ahead if there are two or more
  bool json = false;
  bool no_report = false;
  bool quiet = false;
  bool profile = false;
};

void add_run_flags(CLI::App& command, RunFlags& flags);

// That of the configuration's flags, with what the others change.
[[nodiscard]] Config resolve_config(const RunFlags& flags);

// The method's name, also where it was left to the default.
[[nodiscard]] std::string method_name(const RunFlags& flags);

}  // namespace edvo::app
