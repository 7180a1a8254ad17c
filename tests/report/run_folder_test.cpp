// SPDX-License-Identifier: MIT
#include "edvo/report/run_folder.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;

TEST(RunFolder, IsNewEachTimeAndLatestPointsToTheLast) {
  const test::TemporaryFolder folder;
  const fs::path first = make_stamped_run_folder(folder.path() / "runs", "room");
  const fs::path second = make_stamped_run_folder(folder.path() / "runs", "room");
  EXPECT_NE(first, second);
  EXPECT_EQ(first.parent_path(), folder.path() / "runs/room");
  EXPECT_TRUE(fs::is_empty(first));
  EXPECT_TRUE(fs::equivalent(folder.path() / "runs/room/latest", second));
}

TEST(RunFolder, LeavesAloneWhatTheUserCalledLatest) {
  const test::TemporaryFolder folder;
  folder.write("runs/room/latest", "mine");
  (void)make_stamped_run_folder(folder.path() / "runs", "room");
  EXPECT_TRUE(fs::is_regular_file(folder.path() / "runs/room/latest"));
}

TEST(RunFolder, TakesNoWayOutOfItsParentFromASequenceName) {
  const test::TemporaryFolder folder;
  const fs::path runs = folder.path() / "runs";
  for (const char* name : {"../../up", "..", "", "a/b"})
    EXPECT_EQ(make_stamped_run_folder(runs, name).parent_path().parent_path(), runs) << name;
}

TEST(RunFolder, IsMadeWithItsParentsOrTakenWhenEmpty) {
  const test::TemporaryFolder folder;
  make_named_run_folder(folder.path() / "a/b", false);
  make_named_run_folder(folder.path() / "a/b", false);
  EXPECT_TRUE(fs::is_directory(folder.path() / "a/b"));
}

TEST(RunFolder, RefusesToReplaceAnEarlierRunUnlessForced) {
  const test::TemporaryFolder folder;
  folder.write("frames.jsonl", "{}\n");
  folder.write("report.html", "old");
  folder.write("notes.txt", "mine");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {folder.path().string(), "earlier run", "--force"},
                         [&] { make_named_run_folder(folder.path(), false); }));
  EXPECT_TRUE(fs::exists(folder.path() / "report.html"));
  make_named_run_folder(folder.path(), true);
  EXPECT_FALSE(fs::exists(folder.path() / "report.html"));
  EXPECT_TRUE(fs::exists(folder.path() / "notes.txt"));
}

TEST(RunFolder, RefusesAFolderWithOtherThings) {
  const test::TemporaryFolder folder;
  folder.write("notes.txt", "mine");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"not empty"},
                         [&] { make_named_run_folder(folder.path(), false); }));
}

TEST(RunFolder, CannotBeAFile) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.write("file", "");
  EXPECT_TRUE(
      fails_with(ErrorCode::kOutput, {"is a file"}, [&] { make_named_run_folder(file, true); }));
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"cannot create"},
                         [&] { make_named_run_folder(file / "below", false); }));
}

}  // namespace
}  // namespace edvo
