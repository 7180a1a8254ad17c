// SPDX-License-Identifier: MIT
// Files of edge strength, as --edge-cache keeps them: as they are, and with the right checksum, so
// that what comes after it is reached.
#include "edvo/core/error.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/strength_file.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/scratch_folder.hpp"

using namespace edvo;

namespace {

// What a file starts with, before its checksum.
std::string magic() {
  const fuzz::ScratchFolder scratch;
  write_strength(scratch.path() / "file", cv::Mat_<float>::ones(1, 1));
  const std::string bytes = read_file(scratch.path() / "file");
  return bytes.substr(0, bytes.find(sha256(bytes.substr(bytes.size() - 3 * sizeof(float)))));
}

void read(const std::string& path) {
  try {
    fuzz::require(!find_strength(path).value().empty());
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string start = magic();
  static fuzz::MemoryFile file;
  const std::string text(fuzz::text_of(data, size));
  file.write(text);
  read(file.path());
  file.write(start + sha256(text) + text);
  read(file.path());
  return 0;
}
