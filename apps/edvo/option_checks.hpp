// SPDX-License-Identifier: MIT
// What holds for the values of options of all verbs.
#pragma once

#include <CLI/CLI.hpp>

namespace edvo::app {

// A number from lowest to highest. CLI::Range lets nan pass.
[[nodiscard]] CLI::Validator number_between(double lowest, double highest);

// Refuses an empty value of any option of the program and its verbs, as "$FILE" without a FILE
// gives: it would count as not given.
void refuse_empty_values(CLI::App& program);

}  // namespace edvo::app
