// SPDX-License-Identifier: MIT
// When a tracked frame becomes a keyframe (paper, section III-C, fig. 4).
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/image/frame.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/odometry/frame_result.hpp"
#include "edvo/odometry/tracking_state.hpp"

#include <optional>

namespace edvo {

class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options) : options_(options) {}

  // The reason why the frame becomes a keyframe; none if it does not. result: alignment of the
  // frame to the reference keyframe. state: after this frame.
  [[nodiscard]] std::optional<KeyframeReason> due(const AlignResult& result, const Frame& frame,
                                                  const TrackingState& state) const;

 private:
  KeyframeOptions options_;
};

}  // namespace edvo
