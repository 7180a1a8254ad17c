// SPDX-License-Identifier: MIT
#include "edvo/io/output_file.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

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
