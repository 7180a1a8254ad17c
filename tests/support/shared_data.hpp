// SPDX-License-Identifier: MIT
// Real data beside the repository, for tests that use it where it is there.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace edvo::test {

[[nodiscard]] inline std::filesystem::path shared_data() {
  if (const char* folder = std::getenv("EDVO_SHARED_DATA")) return folder;
  return std::filesystem::path(EDVO_SOURCE_DIR) / ".." / "shared" / "data";
}

}  // namespace edvo::test

// Skips the test if the file or folder is not there.
#define EDVO_REQUIRE_SHARED(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs " << (path)
