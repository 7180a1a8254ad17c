// SPDX-License-Identifier: MIT
// The parts of `edvo map`, a file each.
#pragma once

#include <CLI/CLI.hpp>

namespace edvo::app {

void add_map_info(CLI::App& verb);
void add_map_export(CLI::App& verb);
void add_map_merge(CLI::App& verb);

}  // namespace edvo::app
