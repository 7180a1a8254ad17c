// SPDX-License-Identifier: MIT
// Poses beside the images: one matrix a line, and one a file.
#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/image_poses.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/scratch_folder.hpp"

using namespace edvo;

namespace {

void read(const std::filesystem::path& root, const std::vector<FrameEntry>& frames) {
  try {
    const std::optional<ImagePoses> poses = read_image_poses(root, frames);
    if (!poses) return;  // none of them is a rigid motion
    for (const StampedPose& pose : poses->trajectory)
      fuzz::require(is_finite(pose.world_from_camera));
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::ScratchFolder lines, files;
  std::vector<FrameEntry> in_lines, in_files;
  for (int i = 0; i < 3; ++i) {
    const std::string number = std::to_string(i);
    const Stamp stamp{i, 9};
    in_lines.push_back({.stamp = stamp, .colour = lines.path() / ("frame" + number + ".jpg")});
    in_files.push_back(
        {.stamp = stamp, .colour = files.path() / ("frame-00000" + number + ".color.png")});
  }
  write_file(lines.path() / "traj.txt", fuzz::text_of(data, size));
  write_file(files.path() / "frame-000000.pose.txt", fuzz::text_of(data, size));
  read(lines.path(), in_lines);
  read(files.path(), in_files);
  return 0;
}
