// SPDX-License-Identifier: MIT
// Counts what the program takes from the heap, through whatever door. Once per program, glibc only.
#pragma once

#include <cstdint>

namespace edvo::test {

// Calls of malloc and its like so far, by all threads.
[[nodiscard]] std::int64_t allocations();

}  // namespace edvo::test
