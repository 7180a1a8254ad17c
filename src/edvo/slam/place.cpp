// SPDX-License-Identifier: MIT
#include "edvo/slam/place.hpp"

#include "edvo/slam/verify_link.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

cv::Mat_<float> full_depth(const Place& place) {
  cv::Mat_<float> depth(place.gray.size());
  for (int y = 0; y < depth.rows; y += 2) {
    const std::uint16_t* const half = place.half_depth[y / 2];
    float* const row = depth[y];
    for (int x = 0; x < depth.cols; ++x)
      row[x] = half[x / 2] > 0 ? kDepthStep * static_cast<float>(half[x / 2])
                               : std::numeric_limits<float>::quiet_NaN();
    if (y + 1 < depth.rows) std::copy(row, row + depth.cols, depth[y + 1]);
  }
  return depth;
}

cv::Mat_<cv::Vec2b> make_half_chroma(const cv::Mat_<cv::Vec3b>& bgr) {
  cv::Mat_<cv::Vec3b> half((bgr.rows + 1) / 2, (bgr.cols + 1) / 2);
  for (int y = 0; y < half.rows; ++y)
    for (int x = 0; x < half.cols; ++x) half(y, x) = bgr(2 * y, 2 * x);
  cv::cvtColor(half, half, cv::COLOR_BGR2YCrCb);
  cv::Mat_<cv::Vec2b> chroma(half.size());
  for (int y = 0; y < half.rows; ++y)
    for (int x = 0; x < half.cols; ++x) chroma(y, x) = {half(y, x)[1], half(y, x)[2]};
  return chroma;
}

}  // namespace

Place make_place(const Keyframe& keyframe, bool keep_colour) {
  constexpr float kMostSteps = std::numeric_limits<std::uint16_t>::max();
  Place place{.id = keyframe.id,
              .stamp = keyframe.stamp,
              .shutter = keyframe.shutter,
              .gray = keyframe.gray};
  const cv::Mat_<float>& depth = keyframe.depth;
  place.half_depth.create((depth.rows + 1) / 2, (depth.cols + 1) / 2);
  for (int y = 0; y < place.half_depth.rows; ++y)
    for (int x = 0; x < place.half_depth.cols; ++x) {
      const float steps = std::round(depth(2 * y, 2 * x) / kDepthStep);
      place.half_depth(y, x) =
          steps > 0 && steps <= kMostSteps ? static_cast<std::uint16_t>(steps) : 0;
    }
  if (keep_colour) place.half_chroma = make_half_chroma(keyframe.bgr);
  place.points.reserve(keyframe.points.size());
  for (const ColoredPoint& point : keyframe.points) place.points.push_back(point.position);
  return place;
}

KeyframePtr keyframe_of(const Place& place) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->id = place.id;
  keyframe->stamp = place.stamp;
  keyframe->shutter = place.shutter;
  keyframe->gray = place.gray;
  cv::cvtColor(place.gray, keyframe->bgr, cv::COLOR_GRAY2BGR);
  keyframe->depth = full_depth(place);
  keyframe->points.reserve(place.points.size());
  for (const Eigen::Vector3f& point : place.points) keyframe->points.push_back({.position = point});
  return keyframe;
}

FernCode make_fern_code(const Place& place) {
  return make_fern_code(place.gray, full_depth(place));
}

PlaceSignature make_signature(const Place& place, const Camera& camera) {
  const KeyframePtr keyframe = keyframe_of(place);
  const Frame frame =
      make_frame({.stamp = place.stamp, .bgr = keyframe->bgr, .depth = keyframe->depth},
                 make_undistortion({.pinhole = camera}));
  return {.code = make_fern_code(place.gray, keyframe->depth),
          .features = describe_corners(frame, kFeaturesPerKeyframe)};
}

}  // namespace edvo
