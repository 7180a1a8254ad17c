// SPDX-License-Identifier: MIT
// A keyframe as it is kept to recognize its place: as little as finding and verifying takes.
#pragma once

#include "edvo/features/corner_features.hpp"
#include "edvo/map/keyframe.hpp"
#include "edvo/slam/place_index.hpp"

#include <vector>

namespace edvo {

struct Place {
  std::int64_t id = 0;  // of the keyframe
  Stamp stamp;
  RollingShutter shutter;
  cv::Mat_<std::uint8_t> gray;          // H x W, shared with the keyframe
  cv::Mat_<std::uint16_t> half_depth;   // of every second pixel [kDepthStep], 0 = none
  cv::Mat_<cv::Vec2b> half_chroma;      // of every second pixel (Cr, Cb); empty = not kept
  std::vector<Eigen::Vector3f> points;  // selected pixels, in its camera [m]
};

constexpr float kDepthStep = 0.25e-3F;  // [m]

[[nodiscard]] Place make_place(const Keyframe& keyframe, bool keep_colour = false);

// The keyframe again, without colour.
[[nodiscard]] KeyframePtr keyframe_of(const Place& place);

[[nodiscard]] FernCode make_fern_code(const Place& place);

// What tells places apart.
struct PlaceSignature {
  FernCode code{};
  std::vector<CornerFeature> features;
};

[[nodiscard]] PlaceSignature make_signature(const Place& place, const Camera& camera);

}  // namespace edvo
