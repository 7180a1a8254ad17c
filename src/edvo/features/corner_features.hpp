// SPDX-License-Identifier: MIT
// Corners of a keyframe with a point in space and a binary descriptor, and the rigid motion between
// two keyframes' corners.
//
// Shi-Tomasi corners; descriptors compare pairs of smoothed pixels (Calonder and others 2010,
// BRIEF), turned by the intensity centroid (Rosin 1999, as in ORB). The patch has one size in
// space, so that its size in the image follows the depth and descriptors do not depend on scale.
#pragma once

#include "edvo/core/se3.hpp"
#include "edvo/image/frame.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace edvo {

using Descriptor = std::array<std::uint64_t, 4>;

struct CornerFeature {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();  // in the camera [m]
  Descriptor descriptor{};
};

constexpr std::size_t kFeaturesPerKeyframe = 400;

// At most `count` corners with depth, spread over the image, in row order of their cells.
[[nodiscard]] std::vector<CornerFeature> describe_corners(const Frame& frame, std::size_t count);

// Number of bits that differ.
[[nodiscard]] int distance(const Descriptor& a, const Descriptor& b);

// Share of a keyframe's corners that look alike where a motion brings them in another frame [0..1]:
// of those that lie on the surface seen there; 0 if these are few.
[[nodiscard]] double alike_share(const std::vector<CornerFeature>& features, const Frame& frame,
                                 const SE3& frame_from_features);

struct FeatureMatch {
  std::size_t a = 0, b = 0;  // indices
};

// Pairs that are each other's nearest and clearly nearer than the second.
[[nodiscard]] std::vector<FeatureMatch> match_features(const std::vector<CornerFeature>& a,
                                                       const std::vector<CornerFeature>& b);

struct CornerMotion {
  SE3 b_from_a;
  std::vector<FeatureMatch> inliers;
};

// RANSAC over triples of matches (Fischler, Bolles 1981), then least squares on all inliers. The
// same seed gives the same bits.
[[nodiscard]] CornerMotion estimate_motion(const std::vector<CornerFeature>& a,
                                           const std::vector<CornerFeature>& b,
                                           const std::vector<FeatureMatch>& matches,
                                           std::uint64_t seed);

}  // namespace edvo
