// SPDX-License-Identifier: MIT
// The verbs of the program: each file adds one subcommand, main.cpp lists them.
#pragma once

#include "extension.hpp"

#include <CLI/CLI.hpp>

namespace edvo::app {

// Each adds its subcommand with options and a callback. The callback throws edvo::Error on bad
// input. The extension must live as long as the program.
void add_run_command(CLI::App& program, const Extension& extension);
void add_eval_command(CLI::App& program);
void add_demo_command(CLI::App& program, const Extension& extension);
void add_synth_command(CLI::App& program);
void add_report_command(CLI::App& program);
void add_bench_command(CLI::App& program, const Extension& extension);
void add_edges_command(CLI::App& program);
void add_models_command(CLI::App& program);
void add_map_command(CLI::App& program);
void add_config_command(CLI::App& program);
void add_cache_command(CLI::App& program);
void add_manual_commands(CLI::App& program);

// A verb of the extension: all words after its name are its own.
void add_extension_verb(CLI::App& program, const Extension::Verb& verb);

// Options that the extension adds to a verb; values must live as long as it.
void add_extension_options(CLI::App& verb, const std::vector<Extension::Option>& options,
                           Extension::Values& values);

}  // namespace edvo::app
