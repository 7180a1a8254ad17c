// SPDX-License-Identifier: MIT
// Writes results so that the files on disk are valid at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace edvo {

// A text file that grows line by line. Each line is passed to the system at once and complete, so a
// killed program leaves only complete lines. A line that does not fit on the disk is removed.
class LineFile {
 public:
  // Creates or empties the file. Throws Error(kOutput) naming it.
  explicit LineFile(std::filesystem::path path);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  // Appends the line and a line end. Throws Error(kOutput) naming the file, also if the file is no
  // longer at its path.
  void append(std::string_view line);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t whole_bytes_ = 0;  // length of the whole lines
};

// A file that appears whole or not at all: it is written beside its place, and moved there by
// commit(). Until then, and where that fails, the file that was there stays. A symbolic link stays
// one: its target is replaced. What is no regular file (a FIFO, a device) is written straight into.
class WholeFile {
 public:
  // Throws Error(kOutput) naming the file, as the members do.
  explicit WholeFile(std::filesystem::path path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void append(std::string_view bytes);

  // When this returns, all is on the disk and at its path. Call it once, the last.
  void commit();

 private:
  [[noreturn]] void fail(int error_number);

  std::filesystem::path path_;
  std::filesystem::path place_, unfinished_;  // empty = written straight into path_
  int descriptor_ = -1;
};

// Creates the folder and its parents. Throws Error(kOutput) naming the folder, with the remedy at
// the end of the message.
void make_folder(const std::filesystem::path& folder, std::string_view remedy = {});

// Where writing the path writes: the end of its symbolic links, whether that exists or not. Throws
// Error(kOutput) where they go round in a circle.
[[nodiscard]] std::filesystem::path followed(std::filesystem::path path);

// Whether writing this file would replace something: a regular file that is not empty.
[[nodiscard]] bool would_be_lost(const std::filesystem::path& path);

// Replaces the file by the content, as WholeFile does.
void write_whole(const std::filesystem::path& path, std::string_view content);

}  // namespace edvo
