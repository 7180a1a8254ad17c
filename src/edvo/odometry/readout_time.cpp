// SPDX-License-Identifier: MIT
#include "edvo/odometry/readout_time.hpp"

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

constexpr double kMemory = 20;  // frames
constexpr int kLeastFrames = 20;
constexpr double kClearly = 4;            // standard deviations
constexpr double kLeastSeconds = 3.5e-3;  // of global shutters up to 2.9 ms were seen
constexpr double kLongest = 1.0 / 15;     // [s]

}  // namespace

void ReadoutTime::observe(const ReadoutEvidence& evidence) {
  if (!(evidence.information > 0)) return;
  const double keep = 1 - 1 / kMemory;
  weights_ = keep * weights_ + evidence.information;
  weighted_ = keep * weighted_ + evidence.information * evidence.seconds;
  const double error = evidence.information * (evidence.seconds - weighted_ / weights_);
  scatter_ = keep * keep * scatter_ + error * error;
  ++frames_;
}

double ReadoutTime::seconds() const {
  if (frames_ < kLeastFrames) return 0;
  const double mean = weighted_ / weights_;
  const bool is_clear = std::abs(mean) > kClearly * std::sqrt(scatter_) / weights_;
  return is_clear && std::abs(mean) > kLeastSeconds ? std::clamp(mean, -kLongest, kLongest) : 0;
}

Vector6d velocity_since(const TrackingState& last, const SE3& cur_from_ref, const Stamp& stamp) {
  if (!last.stamp) return Vector6d::Zero();
  const double seconds = seconds_between(*last.stamp, stamp);
  if (last.motion_seconds > 0 && is_far_ahead(last, seconds)) return Vector6d::Zero();
  return log(last.alignment.cur_from_ref * inverse(cur_from_ref)) / seconds;
}

}  // namespace edvo
