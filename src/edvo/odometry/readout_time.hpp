// SPDX-License-Identifier: MIT
// A rolling shutter reads an image row by row while the camera moves (docs/adr/0013).
#pragma once

#include "edvo/align/readout_evidence.hpp"
#include "edvo/core/stamp.hpp"
#include "edvo/odometry/tracking_state.hpp"

namespace edvo {

// Estimates how long a camera takes to read an image, from the first row to the last, by what
// tracked frames tell of it. A value.
class ReadoutTime {
 public:
  // evidence: of a frame that was aligned with seconds() as its readout time.
  void observe(const ReadoutEvidence& evidence);

  // 0 until frames have told clearly that it is not; negative where the last row comes first. [s]
  [[nodiscard]] double seconds() const;

 private:
  // Sums over frames of their weights, times their estimates, and times those and their squared
  // differences from the mean: with older ones forgotten.
  double weights_ = 0, weighted_ = 0, scatter_ = 0;
  int frames_ = 0;
};

// The camera's velocity at a frame, (rho [m/s], phi [rad/s]) in its own coordinates: that of its
// motion since the last good one, or zero where that is too long ago to tell.
[[nodiscard]] Vector6d velocity_since(const TrackingState& last, const SE3& cur_from_ref,
                                      const Stamp& stamp);

}  // namespace edvo
