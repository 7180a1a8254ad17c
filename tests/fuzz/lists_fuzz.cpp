// SPDX-License-Identifier: MIT
// The lists of a sequence: rgb.txt up to the first NUL, depth.txt after it, or the whole text as an
// association file.
#include "edvo/core/error.hpp"
#include "edvo/io/dataset_layout.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/text_list.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/scratch_folder.hpp"

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFolder scratch;
  const std::string_view text = fuzz::text_of(data, size);
  const std::string_view first = text.substr(0, text.find('\0'));
  const std::string_view rest = text.substr(std::min(first.size() + 1, text.size()));
  write_file(scratch.path() / "rgb.txt", first);
  write_file(scratch.path() / "depth.txt", rest);
  try {
    const Listing listing = read_tum_lists(scratch.path(), {});
    for (std::size_t i = 1; i < listing.frames.size(); ++i)
      fuzz::require(listing.frames[i - 1].stamp < listing.frames[i].stamp);
  } catch (const Error&) {
  }
  try {
    static_cast<void>(read_association_file(scratch.path() / "rgb.txt", {}));
  } catch (const Error&) {
  }
  return 0;
}
