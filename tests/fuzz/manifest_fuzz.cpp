// SPDX-License-Identifier: MIT
// Manifests of benchmarks.
#include "bench_manifest.hpp"
#include "edvo/core/error.hpp"
#include "fuzz/memory_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static edvo::fuzz::MemoryFile file;
  file.write(edvo::fuzz::text_of(data, size));
  try {
    static_cast<void>(edvo::app::read_manifest(file.path(), {.data = "/proc/self/fd"}));
  } catch (const edvo::Error&) {
  }
  return 0;
}
