// SPDX-License-Identifier: MIT
// The program as a function: what main() of the executable and the command of the Python package
// call.
#pragma once

#include "extension.hpp"

namespace edvo::app {

// Runs the verb that the arguments name; argv[0] is the program. Returns the exit status
// (docs/errors.md) and prints what went wrong on stderr; never throws.
[[nodiscard]] int run_program(int argc, char** argv, const Extension& extension = {});

}  // namespace edvo::app
