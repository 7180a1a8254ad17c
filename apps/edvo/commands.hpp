// SPDX-License-Identifier: MIT
// The verbs of the program: each file adds one subcommand, main.cpp lists them.
#pragma once

#include <CLI/CLI.hpp>

namespace edvo::app {

// Each adds its subcommand with options and a callback. The callback throws edvo::Error on bad
// input.
void add_run_command(CLI::App& program);
void add_eval_command(CLI::App& program);
void add_demo_command(CLI::App& program);
void add_synth_command(CLI::App& program);
void add_bench_command(CLI::App& program);
void add_edges_command(CLI::App& program);
void add_models_command(CLI::App& program);
void add_config_command(CLI::App& program);
void add_cache_command(CLI::App& program);

}  // namespace edvo::app
