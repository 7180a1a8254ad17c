// SPDX-License-Identifier: MIT
#include "edvo/io/file.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <thread>

namespace edvo {
namespace {

using test::fails_with;

TEST(ReadStream, ReadsFilesAndPipes) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(read_stream(folder.write("file", "text"), 100), "text");
  const std::string pipe = (folder.path() / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::jthread writer([&pipe] { std::ofstream(pipe) << "from a pipe"; });
  EXPECT_EQ(read_stream(pipe, 100), "from a pipe");
}

TEST(ReadStream, GivesUpAPipeThatNobodyWritesTo) {
  const test::TemporaryFolder folder;
  const std::string pipe = (folder.path() / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"pipe", "nothing arrives"},
                         [&] { (void)read_stream(pipe, 100, std::chrono::milliseconds(20)); }));
}

TEST(ReadStream, GivesUpWhatHasNoEnd) {
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"/dev/zero", "more than 1000 bytes"},
                         [] { (void)read_stream("/dev/zero", 1000); }));
}

}  // namespace
}  // namespace edvo
