// SPDX-License-Identifier: MIT
// What the user is shown before a run and after it.
#pragma once

#include "recorded_run.hpp"

namespace edvo::app {

// What was picked and why, and what looks wrong, on stderr; with --quiet only the latter.
void show_choices(const RunDescription& run, const RunFlags& flags);

// The result on stdout: a table, or with --json the summary as one object.
void show_result(const RecordedRun& run, const RunFlags& flags);

}  // namespace edvo::app
