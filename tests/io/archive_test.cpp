// SPDX-License-Identifier: MIT
#include "edvo/io/archive.hpp"

#include "edvo/io/dataset.hpp"
#include "edvo/io/file.hpp"
#include "support/error_matcher.hpp"
#include "support/small_sequence.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <algorithm>
#include <csignal>
#include <vector>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;
using test::TemporaryFolder;
using testing::HasSubstr;
using testing::SizeIs;

struct Entry {
  std::string name;
  std::string content = {};
  std::string symlink_to = {};
  std::string hardlink_to = {};
};

enum class Format { kTar, kTarGz, kTarXz, kZip };

void write_archive(const fs::path& file, const std::vector<Entry>& entries,
                   Format format = Format::kTarGz) {
  archive* const out = archive_write_new();
  if (format == Format::kZip) {
    archive_write_set_format_zip(out);
  } else {
    archive_write_set_format_pax_restricted(out);
  }
  if (format == Format::kTarGz) archive_write_add_filter_gzip(out);
  if (format == Format::kTarXz) archive_write_add_filter_xz(out);
  ASSERT_EQ(archive_write_open_filename(out, file.c_str()), ARCHIVE_OK);
  for (const Entry& item : entries) {
    archive_entry* const entry = archive_entry_new();
    archive_entry_set_pathname(entry, item.name.c_str());
    archive_entry_set_perm(entry, 0644);
    archive_entry_set_filetype(entry, AE_IFREG);
    if (!item.symlink_to.empty()) {
      archive_entry_set_filetype(entry, AE_IFLNK);
      archive_entry_set_symlink(entry, item.symlink_to.c_str());
    }
    if (!item.hardlink_to.empty()) archive_entry_set_hardlink(entry, item.hardlink_to.c_str());
    archive_entry_set_size(entry, static_cast<la_int64_t>(item.content.size()));
    EXPECT_EQ(archive_write_header(out, entry), ARCHIVE_OK);
    archive_write_data(out, item.content.data(), item.content.size());
    archive_entry_free(entry);
  }
  EXPECT_EQ(archive_write_close(out), ARCHIVE_OK);
  archive_write_free(out);
}

// The files of a folder as entries below a name.
std::vector<Entry> entries_of(const fs::path& folder, const std::string& name) {
  std::vector<Entry> entries;
  for (const auto& item : fs::recursive_directory_iterator(folder))
    if (item.is_regular_file())
      entries.push_back({.name = name + fs::relative(item.path(), folder).string(),
                         .content = read_file(item.path())});
  return entries;
}

struct ArchiveTest : testing::Test {
  [[nodiscard]] std::size_t cached() const {
    return fs::exists(cache) ? static_cast<std::size_t>(std::distance(fs::directory_iterator(cache),
                                                                      fs::directory_iterator{}))
                             : 0;
  }
  [[nodiscard]] fs::path file(const char* name) const { return folder.path() / name; }

  TemporaryFolder folder;
  fs::path cache = folder.path() / "cache";
};

TEST_F(ArchiveTest, ASequenceIsOpenedFromEveryKindOfArchive) {
  test::write_tum_sequence(folder.path() / "sequence", 3);
  const auto entries = entries_of(folder.path() / "sequence", "rgbd_dataset_freiburg1_tiny/");
  for (const auto& [name, format] :
       {std::pair{"fr1_a.tar", Format::kTar}, std::pair{"fr1_b.tgz", Format::kTarGz},
        std::pair{"fr1_c.tar.xz", Format::kTarXz}, std::pair{"fr1_d.zip", Format::kZip}}) {
    write_archive(file(name), entries, format);
    const Dataset dataset = open_dataset(file(name), {.cache = cache});
    EXPECT_EQ(dataset.name, std::string(name).substr(0, 5));
    EXPECT_THAT(dataset.frames, SizeIs(3));
    EXPECT_EQ(read_frame(dataset, 2).bgr(0, 0)[0], 2);
    EXPECT_THAT(dataset.notes, testing::Contains(HasSubstr("unpacked in")));
  }
}

TEST_F(ArchiveTest, ASequenceWithoutAFolderOfItsOwnIsOpenedToo) {
  test::write_tum_sequence(folder.path() / "sequence", 2);
  write_archive(file("a.tgz"), entries_of(folder.path() / "sequence", "./"));
  EXPECT_THAT(open_dataset(file("a.tgz"), {.cache = cache}).frames, SizeIs(2));
}

TEST_F(ArchiveTest, IsUnpackedOnceUntilItChanges) {
  write_archive(file("a.tgz"), {{.name = "x", .content = "1"}});
  const fs::path first = unpack_archive(file("a.tgz"), cache);
  folder.write(fs::relative(first / "mark", folder.path()), "");
  EXPECT_EQ(unpack_archive(file("a.tgz"), cache), first);
  EXPECT_TRUE(fs::exists(first / "mark"));
  write_archive(file("a.tgz"), {{.name = "x", .content = "other"}});
  const fs::path second = unpack_archive(file("a.tgz"), cache);
  EXPECT_NE(second, first);
  EXPECT_EQ(read_file(second / "x"), "other");
}

TEST_F(ArchiveTest, LeftoversOfAKilledRunAreReplaced) {
  write_archive(file("a.tgz"), {{.name = "x", .content = "1"}});
  const fs::path target = unpack_archive(file("a.tgz"), cache);
  fs::rename(target, target.string() + ".partial");
  folder.write(fs::relative(target.string() + ".partial/old", folder.path()), "");
  EXPECT_EQ(unpack_archive(file("a.tgz"), cache), target);
  EXPECT_FALSE(fs::exists(target / "old"));
  EXPECT_EQ(cached(), 1U);
}

TEST_F(ArchiveTest, EntriesThatLeadOutAreRefused) {
  for (const char* const name : {"../evil", "a/../../evil", "/tmp/edvo-evil", "a/.."}) {
    write_archive(file("a.tar"), {{.name = "ok", .content = "1"}, {.name = name, .content = "2"}},
                  Format::kTar);
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.tar", name, "outside"},
                           [&] { (void)unpack_archive(file("a.tar"), cache); }));
  }
  EXPECT_EQ(cached(), 0U);
  EXPECT_FALSE(fs::exists(folder.path() / "evil"));
  EXPECT_FALSE(fs::exists("/tmp/edvo-evil"));
}

TEST_F(ArchiveTest, LinksAreRefused) {
  write_archive(file("a.tgz"), {{.name = "rgb", .symlink_to = "/etc"}, {.name = "rgb/passwd"}});
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"'rgb'", "neither a plain file nor a folder"},
                         [&] { (void)unpack_archive(file("a.tgz"), cache); }));
  write_archive(file("b.tgz"), {{.name = "a", .content = "1"}, {.name = "b", .hardlink_to = "a"}});
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"'b'", "neither a plain file nor a folder"},
                         [&] { (void)unpack_archive(file("b.tgz"), cache); }));
  EXPECT_EQ(cached(), 0U);
}

TEST_F(ArchiveTest, ListsInAnArchiveMayNotNameFilesOutside) {
  test::write_tum_sequence(folder.path() / "sequence", 1);
  folder.write("sequence/rgb.txt", "10.0 /etc/passwd\n");
  write_archive(file("a.tgz"), entries_of(folder.path() / "sequence", ""));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"outside", "/etc/passwd"},
                         [&] { (void)open_dataset(file("a.tgz"), {.cache = cache}); }));
}

TEST_F(ArchiveTest, AnArchiveMadeToFillTheDiskIsRefused) {
  write_archive(file("bomb.tgz"),
                {{.name = "zeros", .content = std::string(std::size_t{80} << 20, '\0')}});
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"bomb.tgz", "more than 100 times"},
                         [&] { (void)unpack_archive(file("bomb.tgz"), cache); }));
  EXPECT_EQ(cached(), 0U);
}

TEST_F(ArchiveTest, ADamagedArchiveLeavesNothingBehind) {
  test::write_tum_sequence(folder.path() / "sequence", 5);
  for (const Format format : {Format::kTarGz, Format::kZip}) {
    write_archive(file("a.bin"), entries_of(folder.path() / "sequence", ""), format);
    const std::string whole = read_file(file("a.bin"));
    for (const std::size_t percent : {0, 1, 30, 60, 95}) {
      folder.write("a.bin", whole.substr(0, whole.size() * percent / 100));
      EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.bin"}, [&] {
        (void)unpack_archive(file("a.bin"), cache);
      })) << percent;
    }
  }
  folder.write("a.bin", "This is no archive, only text. " + std::string(2000, 'x'));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.bin", "tar or zip archive"},
                         [&] { (void)unpack_archive(file("a.bin"), cache); }));
  EXPECT_EQ(cached(), 0U);
}

TEST_F(ArchiveTest, ACacheThatCannotBeWrittenIsAnOutputError) {
  write_archive(file("a.tgz"), {{.name = "x", .content = "1"}});
  folder.write("file", "");
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"file/cache", "XDG_CACHE_HOME"},
                         [&] { (void)unpack_archive(file("a.tgz"), file("file/cache")); }));
}

// libarchive gives no reason for some of these.
TEST_F(ArchiveTest, ADamagedHeaderOfACompressedTarIsAnInputError) {
  for (const std::string bytes : {"\x1f\x8b", "\x1f\x8b\x08\xff", "BZh9",
                                  "\xfd"
                                  "7zXZ",
                                  "PK\x03\x04", "\x28\xb5\x2f\xfd"}) {
    folder.write("a.tgz", bytes);
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.tgz"}, [&] {
      (void)unpack_archive(file("a.tgz"), cache);
    })) << bytes;
    folder.write("a.tgz", bytes + std::string(100'000, '\x55'));
    EXPECT_TRUE(fails_with(ErrorCode::kInput, {"a.tgz"}, [&] {
      (void)unpack_archive(file("a.tgz"), cache);
    })) << bytes;
  }
}

TEST_F(ArchiveTest, AnArchiveWithoutASequenceDoesNotStayInTheCache) {
  write_archive(file("a.tgz"), {{.name = "x", .content = ""}, {.name = "y", .content = ""}});
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"no RGB-D sequence"},
                         [&] { (void)open_dataset(file("a.tgz"), {.cache = cache}); }));
  EXPECT_EQ(cached(), 0U);
}

TEST_F(ArchiveTest, WithoutACacheTheErrorTellsWhatToSet) {
  write_archive(file("a.tgz"), {{.name = "x", .content = "1"}});
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"a.tgz", "XDG_CACHE_HOME or HOME"},
                         [&] { (void)open_dataset(file("a.tgz")); }));
}

// A limit on the size of files stands in for a full disk: writes fail in the same way.
TEST_F(ArchiveTest, AFullDiskIsAnOutputErrorAndLeavesNothingBehind) {
  write_archive(file("a.tgz"), {{.name = "small", .content = "1"},
                                {.name = "large", .content = std::string(100'000, 'x')}});
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{.rlim_cur = 10'000, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  const auto error = test::error_of([&] { (void)unpack_archive(file("a.tgz"), cache); });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->code(), ErrorCode::kOutput);
  EXPECT_THAT(error->what(), HasSubstr("large: cannot be written, File too large"));
  EXPECT_EQ(cached(), 0U);
}

TEST_F(ArchiveTest, ProgressIsToldAndMayEndTheUnpacking) {
  write_archive(file("a.tgz"),
                {{.name = "a", .content = "1"}, {.name = "b", .content = std::string(9999, 'b')}});
  std::vector<double> shares;
  struct Stop {};
  EXPECT_THROW((void)unpack_archive(file("a.tgz"), cache, [](double) { throw Stop{}; }), Stop);
  EXPECT_EQ(cached(), 0U);
  (void)unpack_archive(file("a.tgz"), cache, [&](double share) { shares.push_back(share); });
  EXPECT_THAT(shares, SizeIs(2));
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_LE(shares.back(), 1.0);
}

}  // namespace
}  // namespace edvo
