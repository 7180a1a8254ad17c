// SPDX-License-Identifier: MIT
// PNG and JPEG, colour and depth; where the fast reader of plain PNG takes a file, its pixels are
// those of the general one.
#include "edvo/core/error.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/io/plain_png.hpp"
#include "fuzz/memory_file.hpp"

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::MemoryFile file;
  file.write(fuzz::text_of(data, size));
  try {
    fuzz::require(!read_colour(file.path()).empty());
  } catch (const Error&) {
  }
  try {
    const cv::Mat_<std::uint16_t> raw = read_depth_raw(file.path());
    fuzz::require(depth_to_metres(raw, 5000).size() == raw.size());
  } catch (const Error&) {
  }
  return 0;
}
