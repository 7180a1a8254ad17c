// SPDX-License-Identifier: MIT
// Writing results so that what is on disk is whole at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace edvo {

// A text file that grows line by line. Each line goes to the system at once and whole, so a killed
// program leaves only whole lines behind; a line that did not fit on the disk is taken back.
class LineFile {
 public:
  // Creates or empties the file. Throws Error(kOutput) naming it.
  explicit LineFile(std::filesystem::path path);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  // Adds the line and a line end. Throws Error(kOutput) naming the file, also where it is no longer
  // at its path.
  void append(std::string_view line);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  std::int64_t whole_bytes_ = 0;  // length of the whole lines
};

// With the folders above it. Throws Error(kOutput) naming it and, in the end, the remedy.
void make_folder(const std::filesystem::path& folder, std::string_view remedy = {});

// Replaces the file by the content, or, when that throws Error(kOutput), leaves it as it was.
void write_whole(const std::filesystem::path& path, std::string_view content);

}  // namespace edvo
