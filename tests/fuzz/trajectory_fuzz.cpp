// SPDX-License-Identifier: MIT
// Trajectories; what is read can be written, read again, and evaluated against itself.
#include "edvo/core/error.hpp"
#include "edvo/eval/evaluate.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "fuzz/memory_file.hpp"

#include <cmath>

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Trajectory trajectory;
  try {
    trajectory = parse_trajectory(fuzz::text_of(data, size), "fuzz").trajectory;
  } catch (const Error&) {
    return 0;
  }
  std::string text;
  for (const StampedPose& pose : trajectory) {
    fuzz::require(is_finite(pose.world_from_camera));
    text += trajectory_line(pose) + '\n';
  }
  const Trajectory again = parse_trajectory(text, "again").trajectory;
  fuzz::require(again.size() == trajectory.size());
  for (std::size_t i = 0; i < again.size(); ++i)
    fuzz::require(again[i].stamp == trajectory[i].stamp);
  try {
    static_cast<void>(evaluate(trajectory, again, {}));
  } catch (const Error&) {
  }
  return 0;
}
