// SPDX-License-Identifier: MIT
#include "edvo/saved_map/map_views.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

const MapKeyframe& keyframe_of_view(const SavedMap& map, const Place& view) {
  return map.keyframes[static_cast<std::size_t>(view.id)];
}

cv::Mat_<cv::Vec3b> half_rgb(const Place& view) {
  constexpr std::uint8_t kNoChroma = 128;
  cv::Mat_<cv::Vec3b> image(view.half_depth.size());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec2b chroma =
          view.half_chroma.empty() ? cv::Vec2b::all(kNoChroma) : view.half_chroma(y, x);
      image(y, x) = {view.gray(2 * y, 2 * x), chroma[0], chroma[1]};
    }
  cv::cvtColor(image, image, cv::COLOR_YCrCb2RGB);
  return image;
}

cv::Mat_<float> half_depth(const Place& view) {
  cv::Mat_<float> depth(view.half_depth.size());
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x)
      depth(y, x) = kDepthStep * static_cast<float>(view.half_depth(y, x));
  return depth;
}

}  // namespace

std::vector<DepthView> depth_views(const SavedMap& map, int segment) {
  std::vector<DepthView> views;
  for (const Place& view : map.views) {
    const MapKeyframe& key = keyframe_of_view(map, view);
    if (key.segment == segment)
      views.push_back({.camera = half_size(map.origin.camera),
                       .world_from_camera = key.world_from_camera,
                       .depth = half_depth(view),
                       .rgb = half_rgb(view)});
  }
  return views;
}

std::vector<ColoredPoint> colored_points(const SavedMap& map, int segment) {
  std::vector<ColoredPoint> points;
  for (const Place& view : map.views) {
    const MapKeyframe& key = keyframe_of_view(map, view);
    if (key.segment != segment) continue;
    const cv::Mat_<cv::Vec3b> rgb = half_rgb(view);
    for (const Eigen::Vector3f& point : view.points) {
      const Eigen::Vector2d pixel = project(half_size(map.origin.camera), point.cast<double>());
      const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, rgb.cols - 1);
      const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, rgb.rows - 1);
      const cv::Vec3b& color = rgb(y, x);
      points.push_back({.position = (key.world_from_camera * point.cast<double>()).cast<float>(),
                        .rgb = {color[0], color[1], color[2]}});
    }
  }
  return points;
}

int largest_segment(const SavedMap& map) {
  int largest = 0;
  std::ptrdiff_t most = 0;
  for (const int segment : segments_of(map)) {
    const std::ptrdiff_t count =
        std::count_if(map.keyframes.begin(), map.keyframes.end(),
                      [segment](const MapKeyframe& key) { return key.segment == segment; });
    if (count <= most) continue;
    most = count;
    largest = segment;
  }
  return largest;
}

}  // namespace edvo
