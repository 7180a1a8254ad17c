// SPDX-License-Identifier: MIT
// Archives: all that they write lies in the cache, and nothing stays of what is refused.
#include "edvo/core/error.hpp"
#include "edvo/io/archive.hpp"
#include "edvo/io/file.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/scratch_folder.hpp"

using namespace edvo;
namespace fs = std::filesystem;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFolder scratch;
  const fs::path cache = scratch.path() / "cache";
  write_file(scratch.path() / "a.tgz", fuzz::text_of(data, size));
  try {
    static_cast<void>(unpack_archive(scratch.path() / "a.tgz", cache));
  } catch (const Error&) {
    std::error_code ignored;
    fuzz::require(!fs::exists(cache) || fs::is_empty(cache, ignored));
  }
  fs::remove_all(cache);
  fuzz::require(std::distance(fs::directory_iterator(scratch.path()), {}) == 1);
  return 0;
}
