// SPDX-License-Identifier: MIT
#include "edvo/io/output_file.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
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

TEST(WriteWhole, ReplacesTheTargetOfALink) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "there");
  folder.write("there/file", "old");
  fs::create_symlink("there/file", folder.path() / "link");
  fs::create_symlink("link", folder.path() / "link2");
  fs::create_symlink("there/new", folder.path() / "to_new");
  EXPECT_TRUE(would_be_lost(folder.path() / "link2"));
  write_whole(folder.path() / "link2", "new");
  write_whole(folder.path() / "to_new", "first");
  for (const char* link : {"link", "link2", "to_new"})
    EXPECT_TRUE(fs::is_symlink(folder.path() / link)) << link;
  EXPECT_EQ(text_of(folder.path() / "there/file"), "new");
  EXPECT_EQ(text_of(folder.path() / "there/new"), "first");
  fs::create_symlink("round", folder.path() / "round");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"round", "symbolic links"},
                         [&] { write_whole(folder.path() / "round", "new"); }));
}

TEST(WriteWhole, WritesStraightIntoWhatIsNoRegularFile) {
  const test::TemporaryFolder folder;
  const fs::path fifo = folder.path() / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int reader = ::open(fifo.c_str(), O_RDWR | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_whole(fifo, "text");
  std::array<char, 10> bytes{};
  EXPECT_EQ(::read(reader, bytes.data(), bytes.size()), 4);
  EXPECT_EQ(std::string(bytes.data()), "text");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(fifo));
  fs::create_symlink("/dev/full", folder.path() / "full");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"full", "No space left"},
                         [&] { write_whole(folder.path() / "full", "text"); }));
  EXPECT_TRUE(fs::is_symlink(folder.path() / "full"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator{}), 2);
}

}  // namespace
}  // namespace edvo
