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

// Skips the test where there is no such data at all; a part of it that is missing fails the test.
#define EDVO_REQUIRE_SHARED(path)                                               \
  if (!std::filesystem::exists(path)) {                                         \
    ASSERT_FALSE(std::filesystem::exists(edvo::test::shared_data())) << (path); \
    GTEST_SKIP() << "needs " << (path);                                         \
  }                                                                             \
  static_assert(true)
