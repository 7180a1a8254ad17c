// SPDX-License-Identifier: MIT
// Trajectories as text: one "stamp tx ty tz qx qy qz qw" per line, the format of the TUM benchmark.
#pragma once

#include "edvo/core/trajectory.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

struct TrajectoryFile {
  Trajectory trajectory;              // ordered by stamp, each stamp once, unit quaternions
  std::vector<std::string> warnings;  // what had to be corrected, one line per kind
};

// Fields are separated by white space or commas; "#" starts a comment line, of which
// segment_line() is read; CRLF is fine. Poses out
// of order are sorted; of poses with the same stamp the last one stays, as in the TUM scripts.
// Also read, with a warning that says so: EuRoC's csv (integer nanoseconds, which 16 digits
// or a header with "[ns]" tell, commas, qw qx qy qz, more fields), and files whose comment or first
// line names qw before qx. Throws Error(kInput) "source:line: ..." at a line that is no pose, and
// if the file has no pose.
[[nodiscard]] TrajectoryFile parse_trajectory(std::string_view text, const std::string& source);

[[nodiscard]] TrajectoryFile read_trajectory(const std::filesystem::path& file);

// The comment line that marks a change of the segment: "# segment 1". A file starts in segment 0.
// The motion between poses of different segments is not known.
[[nodiscard]] std::string segment_line(int segment);

// One line without its end. The stamp is written with the digits that it was read with.
[[nodiscard]] std::string trajectory_line(const StampedPose& pose);

// Throws Error(kOutput) and leaves an existing file as it was if it cannot be written.
void write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory);

}  // namespace edvo
