// SPDX-License-Identifier: MIT
// What `edvo run` and `edvo demo` share on the command line.
#pragma once

#include "edvo/odometry/config.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace edvo::app {

struct RunOptions {
  std::string method = "canny+corner";
  std::string config_file;               // empty = the method's own options
  std::vector<std::string> assignments;  // group.field=value
  std::string output;                    // folder, empty = runs/<sequence>/<UTC stamp>
  bool force = false;
  int threads = 2;  // one of them reads ahead if there are two or more
  bool json = false;
  bool no_report = false;
  bool quiet = false;
  bool profile = false;
};

void add_run_options(CLI::App& command, RunOptions& options);

// The method's preset, then the file, then the assignments. Throws Error(kUsage, kConfig, kInput).
[[nodiscard]] Config resolve_config(const RunOptions& options);

}  // namespace edvo::app
