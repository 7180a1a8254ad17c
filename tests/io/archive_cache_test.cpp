// SPDX-License-Identifier: MIT
#include "edvo/io/archive_cache.hpp"

#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <chrono>
#include <string>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

class ArchiveCache : public testing::Test {
 protected:
  // An unpacked archive of one file, last used so long ago.
  void add(const std::string& name, std::size_t bytes, std::chrono::hours unused) const {
    folder_.write(name + "/file", std::string(bytes, 'x'));
    fs::last_write_time(folder_.path() / name, fs::file_time_type::clock::now() - unused);
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const CachedArchive& archive : cached_archives(folder_.path()))
      names.push_back(archive.folder.filename().string());
    return names;
  }
  test::TemporaryFolder folder_;
};

TEST_F(ArchiveCache, ListsArchivesTheLongestUnusedFirstAndNothingElse) {
  add("new.tgz-1f-2e", 1, std::chrono::hours(1));
  add("old.tgz-1f-2e", 1, std::chrono::hours(100));
  add("models", 1, std::chrono::hours(1));
  folder_.write("a-1-2", "a file");
  EXPECT_THAT(names(), ElementsAre("old.tgz-1f-2e", "new.tgz-1f-2e"));
  EXPECT_TRUE(cached_archives(folder_.path() / "nowhere").empty());
}

TEST_F(ArchiveCache, EmptyFilesCountTheirEntries) {
  for (int i = 0; i < 100; ++i) folder_.write("a-1-2/" + std::to_string(i), "");
  EXPECT_GE(cached_archives(folder_.path()).front().bytes, 100U * 4096U);
}

TEST_F(ArchiveCache, IsLimitedByRemovingTheLongestUnused) {
  add("a-1-1", 1'000'000, std::chrono::hours(100));
  add("b-1-1", 1'000'000, std::chrono::hours(50));
  add("c-1-1", 1'000'000, std::chrono::hours(30));
  add("models", 1'000'000, std::chrono::hours(1000));
  limit_cache(folder_.path(), 2'500'000);
  EXPECT_THAT(names(), ElementsAre("b-1-1", "c-1-1"));
  limit_cache(folder_.path(), 2'500'000);
  EXPECT_THAT(names(), ElementsAre("b-1-1", "c-1-1"));
  EXPECT_TRUE(fs::exists(folder_.path() / "models/file"));
}

TEST_F(ArchiveCache, WhatWasUsedWithinADayStays) {
  add("a-1-1", 1'000'000, std::chrono::hours(1));
  limit_cache(folder_.path(), 0);
  EXPECT_THAT(names(), ElementsAre("a-1-1"));
}

}  // namespace
}  // namespace edvo
