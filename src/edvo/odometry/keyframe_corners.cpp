// SPDX-License-Identifier: MIT
#include "edvo/odometry/keyframe_corners.hpp"

namespace edvo {
namespace {

constexpr std::size_t kLeastInliers = 12;  // of a guess, which alignment then verifies
constexpr std::uint64_t kSeed = 0x5eed;

}  // namespace

std::optional<SE3> KeyframeCorners::motion_to(const Frame& frame) {
  if (frame_.levels.empty()) return std::nullopt;
  if (features_.empty()) features_ = describe_corners(frame_, kFeaturesPerKeyframe);
  const std::vector<CornerFeature> features = describe_corners(frame, kFeaturesPerKeyframe);
  const CornerMotion motion =
      estimate_motion(features_, features, match_features(features_, features), kSeed);
  if (motion.inliers.size() < kLeastInliers) return std::nullopt;
  return motion.b_from_a;
}

}  // namespace edvo
