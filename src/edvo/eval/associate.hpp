// SPDX-License-Identifier: MIT
// Pairs the poses of an estimate with those of the ground truth by time.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/core/trajectory.hpp"

#include <cstddef>
#include <vector>

namespace edvo {

// Whose rules an evaluation follows. Small differences between them change the last digits.
enum class Protocol {
  kTum,  // the scripts of the TUM RGB-D benchmark; the ones that papers quote
  kEvo,  // the evo package
};

template <>
struct EnumNames<Protocol> {
  static constexpr auto names = std::to_array<std::pair<Protocol, std::string_view>>({
      {Protocol::kTum, "tum"},
      {Protocol::kEvo, "evo"},
  });
};

struct AssociateOptions {
  Protocol protocol = Protocol::kTum;
  double max_difference = 0.02;  // [s]
  double offset = 0;             // added to the stamps of the estimate [s]
};

struct Match {
  std::size_t truth = 0, estimate = 0;  // indices into the two trajectories
};

// Ordered by time. TUM: closest pairs first, each pose at most once, gap < max_difference. Evo: for
// each pose of the shorter trajectory the closest of the longer one, gap <= max_difference.
[[nodiscard]] std::vector<Match> associate(const Trajectory& truth, const Trajectory& estimate,
                                           const AssociateOptions& options);

// script_seconds() of each pose.
[[nodiscard]] std::vector<double> script_stamps(const Trajectory& trajectory);

}  // namespace edvo
