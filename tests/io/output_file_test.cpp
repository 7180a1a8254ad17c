// SPDX-License-Identifier: MIT
#include "edvo/io/output_file.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <csignal>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(LineFile, HasEachLineOnDiskAtOnce) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.write("lines", "old");
  LineFile file(path);
  EXPECT_EQ(text_of(path), "");
  file.append("one");
  EXPECT_EQ(text_of(path), "one\n");
  file.append("two");
  EXPECT_EQ(text_of(path), "one\ntwo\n");
}

TEST(LineFile, NamesTheFileThatCannotBeWritten) {
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"/no/such/folder/lines", "No such file"},
                         [] { LineFile("/no/such/folder/lines"); }));
  LineFile full("/dev/full");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"/dev/full", "free some space"},
                         [&] { full.append("line"); }));
}

TEST(LineFile, NoticesAtOnceThatItsFileOrFolderIsGone) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "run");
  const fs::path path = folder.path() / "run/lines";
  LineFile file(path);
  file.append("one");
  fs::rename(folder.path() / "run", folder.path() / "moved");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"lines", "removed, moved or replaced"},
                         [&] { file.append("two"); }));
  fs::rename(folder.path() / "moved", folder.path() / "run");
  file.append("two");
  fs::remove_all(folder.path() / "run");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"lines", "removed, moved or replaced"},
                         [&] { file.append("three"); }));
}

TEST(LineFile, TakesBackALineThatReachesTheLimitOfAFile) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "lines";
  LineFile file(path);
  file.append("0123456789");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{.rlim_cur = 15, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  const auto error = test::error_of([&] { file.append("0123456789"); });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_TRUE(error);
  EXPECT_EQ(text_of(path), "0123456789\n");
}

TEST(WriteWhole, ReplacesTheFileAndLeavesNothingBeside) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.write("file", "old");
  write_whole(path, "new");
  EXPECT_EQ(text_of(path), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator{}), 1);
}

TEST(WriteWhole, LeavesWhatWasThereWhenItFails) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.write("file", "old");
  fs::create_symlink("/dev/full", folder.path() / "file.part");
  EXPECT_TRUE(
      fails_with(ErrorCode::kOutput, {"file", "No space left"}, [&] { write_whole(path, "new"); }));
  EXPECT_EQ(text_of(path), "old");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"folder"}, [&] {
    fs::create_directory(folder.path() / "folder");
    write_whole(folder.path() / "folder", "new");
  }));
  EXPECT_FALSE(fs::exists(folder.path() / "folder.part"));
}

}  // namespace
}  // namespace edvo
