// SPDX-License-Identifier: MIT
#include "edvo/odometry/keyframe_policy.hpp"

namespace edvo {
namespace {

constexpr double kGrown = 1.75;    // times the usual sigma: the keyframe explains little
constexpr double kWorseFit = 1.5;  // times the least sigma since the keyframe
constexpr double kPoorFit = 1.5;   // times the usual sigma: a blurred keyframe may be why

// A keyframe taken in motion is blurred; a sharp frame then fits badly, and worse the sharper it
// is, however little it has moved: the pose may drift by centimetres while the camera stands still.
bool keyframe_is_blurred(const AlignResult& result, const Frame& frame, const TrackingState& state,
                         double blur_ratio) {
  return blur_ratio > 0 && result.sigma > kPoorFit * state.usual_sigma &&
         frame.sharpness > blur_ratio * state.keyframe_sharpness;
}

// Where something moves in front of what a keyframe shows, its residuals grow with their own scale,
// and the share of inliers tells nothing.
bool explains_little(const AlignResult& result, const TrackingState& state) {
  return state.moving_object_frames > 0 && result.sigma > kGrown * sigma_baseline(state);
}

// Half the period is enough where frames fit worse than they did: the view has changed, though the
// camera has neither turned nor gone far. But not where something else moves: it hides the view.
bool is_due_by_period(const AlignResult& result, const TrackingState& state, int period) {
  if (period == 0) return false;
  const bool fits_worse = expects_one_motion(state) && state.keyframe_sigma > 0 &&
                          result.sigma > kWorseFit * state.keyframe_sigma;
  return state.frames_since_keyframe >= (fits_worse ? (period + 1) / 2 : period);
}

}  // namespace

std::optional<KeyframeReason> KeyframePolicy::due(const AlignResult& result, const Frame& frame,
                                                  const TrackingState& state) const {
  if (is_due_by_period(result, state, options_.period)) return KeyframeReason::kPeriod;
  const SE3& motion = result.alignment.cur_from_ref;
  if (motion.translation.norm() > options_.translation ||
      rotation_angle(motion) > options_.rotation)
    return KeyframeReason::kMotion;
  if (result.overlap < options_.overlap) return KeyframeReason::kOverlap;
  if (result.inlier_ratio < options_.inliers || explains_little(result, state))
    return KeyframeReason::kInliers;
  if (keyframe_is_blurred(result, frame, state, options_.blur_ratio))
    return KeyframeReason::kSharper;
  return std::nullopt;
}

}  // namespace edvo
