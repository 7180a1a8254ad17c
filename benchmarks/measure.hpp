// SPDX-License-Identifier: MIT
// CPU time, so that a busy machine lengthens nothing.
#pragma once

#include <ctime>

namespace edvo::benchmarks {

// Of all threads of the process so far [s].
[[nodiscard]] inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <typename T>
void keep(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

}  // namespace edvo::benchmarks
