// SPDX-License-Identifier: MIT
// Binary files of named sections, each with its length and checksums, so that any damage is found
// and the section named.
//
// All numbers are little-endian. A file is: magic (8 characters), version (32 bits), CRC-32 of
// these; then sections; the last one is "END ", without content. A section is: name (4 characters),
// length of the content and of what is stored (64 bits each), CRC-32 of these; the stored bytes
// (deflate, RFC 1951, of the content), CRC-32 of them.
#pragma once

#include "edvo/core/error.hpp"
#include "edvo/io/output_file.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

namespace edvo {

// What kind of file it is.
struct SectionFormat {
  std::string_view magic;            // 8 characters
  std::uint32_t version = 1;         // that is written; all up to it are read
  std::string_view noun;             // for messages: "map"
  ErrorCode damage;                  // of the Error that a reader throws
  std::uint64_t largest = 0;         // content of a section [bytes]
  std::uint64_t largest_of_all = 0;  // content of all sections together [bytes]
};

constexpr std::size_t kSectionName = 4;  // characters

// Writes beside the file's place and moves it there in finish(): see WholeFile.
class SectionWriter {
 public:
  SectionWriter(const std::filesystem::path& path, const SectionFormat& format);
  ~SectionWriter();

  // name: kSectionName characters. Throws Error(kOutput) naming the file, as finish() does.
  void add(std::string_view name, std::string_view content);
  void finish();

 private:
  struct Compressor;
  WholeFile file_;
  std::unique_ptr<Compressor> compressor_;
};

struct Section {
  std::string name;
  std::string content;
};

// Reads section by section, and allocates no more than the format allows, nor than 1100 times what
// the file has.
class SectionReader {
 public:
  // Throws Error(kInput) if there is no such file, Error(format.damage) if it is of another kind,
  // newer or damaged.
  SectionReader(const std::filesystem::path& path, const SectionFormat& format);
  ~SectionReader();

  // The next section; one named "END " at the end, after which there is none. Throws
  // Error(format.damage) that names the section.
  [[nodiscard]] Section next();

  // Of the section read last [bytes in the file].
  [[nodiscard]] std::uint64_t stored_bytes() const { return stored_; }

  // What is wrong with a section, as an error.
  [[nodiscard]] Error damaged(std::string_view section, std::string_view what) const;

 private:
  [[nodiscard]] std::string take(std::uint64_t size, std::string_view section);
  [[nodiscard]] std::string inflate(const std::string& stored, std::uint64_t size,
                                    std::string_view section);

  struct Decompressor;
  std::string path_;
  SectionFormat format_;
  std::ifstream file_;
  std::uint64_t left_ = 0;     // bytes of the file not read yet
  std::uint64_t content_ = 0;  // bytes of all sections so far
  std::uint64_t stored_ = 0;
  int number_ = 0;  // of the section read last, from 1
  std::unique_ptr<Decompressor> decompressor_;
};

}  // namespace edvo
