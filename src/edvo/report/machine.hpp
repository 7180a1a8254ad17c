// SPDX-License-Identifier: MIT
// What a run was made with and on: versions, processor, memory.
#pragma once

#include <string>

namespace edvo {

struct Machine {
  std::string edvo;  // version
  std::string compiler;
  std::string opencv, eigen;     // versions
  std::string processor;         // model name
  int hardware_threads = 0;      // as the system reports them
  std::string operating_system;  // name, kernel
};

// Unknown parts read "unknown".
[[nodiscard]] Machine this_machine();

// The most memory this process has held so far. [MB = 10^6 bytes]
[[nodiscard]] double peak_memory();

}  // namespace edvo
