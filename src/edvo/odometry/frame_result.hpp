// SPDX-License-Identifier: MIT
// What the odometry says about each frame.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/core/fields.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/core/stamp.hpp"
#include "edvo/map/map.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace edvo {

enum class FrameStatus {
  kFirst,        // defines the world: its pose is the identity
  kTracked,      // pose estimated
  kLost,         // no trustworthy pose; world_from_camera holds the last good one
  kRestarted,    // begins a new segment at a guessed pose, the last good one
  kRelocalized,  // pose estimated, back in an earlier segment
};

// Whether the pose was estimated: neither guessed nor held.
[[nodiscard]] constexpr bool is_tracked(FrameStatus status) {
  return status == FrameStatus::kFirst || status == FrameStatus::kTracked ||
         status == FrameStatus::kRelocalized;
}

enum class KeyframeReason {
  kFirst,    // nothing to track against yet
  kPeriod,   // N frames since the last keyframe
  kMotion,   // ||xi|| passed Omega
  kOverlap,  // too few of the keyframe's points are still in view
  kInliers,  // too few of the points in view still fit
  kSharper,  // residuals are large, and the frame is sharper than the keyframe
  kRestart,  // tracking starts again here
};

// Why a frame is lost.
enum class LossCause {
  kNone,           // it is not
  kNoDepth,        // hardly a pixel has a depth in range
  kConstantDepth,  // all depths are the same: no sensor measures that
  kNoTexture,      // hardly a pixel has a gradient
  kFewPoints,      // too few pixels have both
  kUnlike,         // the images do not correlate
  kOverlap,        // too few of the keyframe's points are in view
  kOutliers,       // too few of the points in view fit
  kResiduals,      // residuals are far larger than usual, of intensity and of depth
  kTooFast,        // the motion would be faster than any camera moves
  kTwoMotions,     // two motions explain the image, and nothing tells which is the camera's
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
  LossCause loss_cause = LossCause::kNone;
  int segment = 0;           // of the map that the frame belongs to
  KeyframeId keyframe = -1;  // that it was aligned to, -1 = there is none yet
  SE3 keyframe_from_camera;  // of a lost frame, that of the last good one
  SE3 world_from_camera;     // as known when the frame was processed
  // Inverse covariance of xi in keyframe_from_camera * exp(xi), xi = (rho [m], phi [rad]). A frame
  // that begins a segment is its own keyframe and has kExactInformation, a lost one has zero.
  Matrix6d information = Matrix6d::Zero();
  int points = 0;                          // residuals of the finest level
  double inlier_ratio = 0;                 // [0..1] of the points in view
  double overlap = 0;                      // [0..1] of the keyframe's points in view
  double correlation = 0;                  // of fitting points' intensities in both images [-1..1]
  double rms = 0;                          // photometric, inliers [grey levels]
  double readout_seconds = 0;              // of the rolling shutter as estimated so far; 0 = global
  double ego_share = 0;                    // [0..1] of the image: moves along with the camera
  LevelList levels;                        // coarse to fine
  std::optional<KeyframeId> new_keyframe;  // set if this frame became a keyframe
  std::optional<KeyframeReason> keyframe_reason;  // and why
  StageTimes milliseconds;
};

// On the diagonal of the information of a pose that is exact by definition.
constexpr double kExactInformation = 1e12;

template <>
struct EnumNames<FrameStatus> {
  static constexpr auto names = std::to_array<std::pair<FrameStatus, std::string_view>>({
      {FrameStatus::kFirst, "first"},
      {FrameStatus::kTracked, "tracked"},
      {FrameStatus::kLost, "lost"},
      {FrameStatus::kRestarted, "restarted"},
      {FrameStatus::kRelocalized, "relocalized"},
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
      {KeyframeReason::kSharper, "sharper"},
      {KeyframeReason::kRestart, "restart"},
  });
};

template <>
struct EnumNames<LossCause> {
  static constexpr auto names = std::to_array<std::pair<LossCause, std::string_view>>({
      {LossCause::kNone, "none"},
      {LossCause::kNoDepth, "no_depth"},
      {LossCause::kConstantDepth, "constant_depth"},
      {LossCause::kNoTexture, "no_texture"},
      {LossCause::kFewPoints, "few_points"},
      {LossCause::kUnlike, "unlike"},
      {LossCause::kOverlap, "overlap"},
      {LossCause::kOutliers, "outliers"},
      {LossCause::kResiduals, "residuals"},
      {LossCause::kTooFast, "too_fast"},
      {LossCause::kTwoMotions, "two_motions"},
  });
};

}  // namespace edvo
