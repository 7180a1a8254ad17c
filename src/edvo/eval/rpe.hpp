// SPDX-License-Identifier: MIT
// Relative pose error: the error of the motion over a given time or path length.
#pragma once

#include "edvo/eval/associate.hpp"
#include "edvo/eval/statistics.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

enum class DeltaUnit { kSeconds, kFrames, kMetres, kRadians, kDegrees, kAllPairs };

// How far apart the two poses of a pair are. With kAllPairs any two poses make a pair.
struct Delta {
  double value = 1;
  DeltaUnit unit = DeltaUnit::kSeconds;
};

// "1s", "30f", "0.5m", "0.1rad", "10deg" or "all". Throws Error(kUsage) otherwise.
[[nodiscard]] Delta parse_delta(std::string_view text);
[[nodiscard]] std::string to_string(const Delta& delta);

// The unit of an error over delta, to append to "m" or "deg": "/s", "/frame", " per 30 frames".
[[nodiscard]] std::string per_delta(const Delta& delta);

struct RpeOptions {
  Delta delta;
  int max_pairs = 10000;   // more are sampled; 0 = no limit
  std::uint64_t seed = 0;  // of that sampling
};

struct RpeError {
  Stamp from, to;          // of the estimate
  double translation = 0;  // over delta [m]
  double rotation = 0;     // over delta [deg]
};

struct Rpe {
  RpeOptions options;
  Statistics translation;        // over delta [m]
  Statistics rotation;           // over delta [deg]
  std::vector<RpeError> errors;  // one per pair, in order of time unless sampled
  // Pairs of a pose with itself, which occur at gaps of more than twice delta. The TUM scripts
  // count them as errors of zero, and so does edvo, but with a warning.
  std::size_t void_pairs = 0;
};

// TUM: each pose of the estimate with the one nearest to delta later, except with the last one;
// ground truth by nearest stamp within twice its median interval; max_difference is not used.
// Evo: matched poses 0, delta, 2 delta...; frames only, otherwise throws Error(kUsage).
// None if no two poses are delta apart.
[[nodiscard]] std::optional<Rpe> relative_pose_error(const Trajectory& truth,
                                                     const Trajectory& estimate,
                                                     const AssociateOptions& association,
                                                     const RpeOptions& options);

}  // namespace edvo
