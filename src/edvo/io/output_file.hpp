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

// Creates the folder and its parents. Throws Error(kOutput) naming the folder, with the remedy at
// the end of the message.
void make_folder(const std::filesystem::path& folder, std::string_view remedy = {});

// Replaces the file by the content. Throws Error(kOutput) and leaves the file as it was if it
// cannot be written.
void write_whole(const std::filesystem::path& path, std::string_view content);

}  // namespace edvo
