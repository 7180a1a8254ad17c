// SPDX-License-Identifier: MIT
// What the odometry says about each frame.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/core/fields.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/core/stamp.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace edvo {

enum class FrameStatus {
  kFirst,    // defines the world: its pose is the identity
  kTracked,  // pose estimated
  kLost,     // no trustworthy pose; world_from_camera holds the last good one
};

enum class KeyframeReason {
  kFirst,    // nothing to track against yet
  kPeriod,   // N frames since the last keyframe
  kMotion,   // ||xi|| passed Omega
  kOverlap,  // too few of the keyframe's points are still in view
  kInliers,  // too few of the points in view still fit
  kSharper,  // residuals are large, and the frame is blur_ratio than the keyframe
  kLost,     // tracking starts again here
};

// Where the time of a frame went, on whatever thread. [ms]
struct StageTimes {
  double frame = 0;      // undistortion and pyramids
  double edges = 0;      // edge detection, keyframes only
  double corners = 0;    // corner optimization, keyframes only
  double selection = 0;  // pixels of a new keyframe
  double tracking = 0;
  double window = 0;  // joint refinement of keyframes
  double total = 0;
};

struct FrameResult {
  std::int64_t index = 0;  // of the frame in the input, counted from 0
  Stamp stamp;
  FrameStatus status = FrameStatus::kLost;
  SE3 world_from_camera;                    // as known when the frame was processed
  Matrix6d information = Matrix6d::Zero();  // inverse covariance of xi in key_from_camera * exp(xi)
  int points = 0;                           // residuals of the finest level
  double inlier_ratio = 0;                  // [0..1] of the points in view
  double overlap = 0;                       // [0..1] of the keyframe's points in view
  double rms = 0;                           // photometric, inliers [grey levels]
  LevelList levels;                         // coarse to fine
  std::optional<KeyframeReason> keyframe;   // set if this frame became a keyframe
  StageTimes milliseconds;
};

template <>
struct EnumNames<FrameStatus> {
  static constexpr auto names = std::to_array<std::pair<FrameStatus, std::string_view>>({
      {FrameStatus::kFirst, "first"},
      {FrameStatus::kTracked, "tracked"},
      {FrameStatus::kLost, "lost"},
  });
};

template <>
struct EnumNames<KeyframeReason> {
  static constexpr auto names = std::to_array<std::pair<KeyframeReason, std::string_view>>({
      {KeyframeReason::kFirst, "first"},
      {KeyframeReason::kPeriod, "period"},
      {KeyframeReason::kMotion, "motion"},
      {KeyframeReason::kOverlap, "overlap"},
      {KeyframeReason::kInliers, "inliers"},
      {KeyframeReason::kSharper, "blur_ratio"},
      {KeyframeReason::kLost, "lost"},
  });
};

}  // namespace edvo
