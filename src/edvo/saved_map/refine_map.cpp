// SPDX-License-Identifier: MIT
#include "edvo/saved_map/refine_map.hpp"

#include "edvo/image/frame.hpp"
#include "edvo/window/joint_refinement.hpp"

#include <cmath>
#include <map>

namespace edvo {
namespace {

// At most so many of its points, evenly taken; none so near to the border that its patch leaves the
// image.
std::vector<SelectedPixel> refined_pixels(const Place& view, const Camera& camera, int count) {
  constexpr int kBorder = 4;  // [px]
  std::vector<SelectedPixel> pixels;
  for (const Eigen::Vector3f& point : view.points) {
    const Eigen::Vector2d at = project(camera, point.cast<double>());
    const cv::Point pixel(static_cast<int>(std::lround(at.x())),
                          static_cast<int>(std::lround(at.y())));
    if (pixel.x >= kBorder && pixel.y >= kBorder && pixel.x < camera.width - kBorder &&
        pixel.y < camera.height - kBorder)
      pixels.push_back({.pixel = pixel, .depth = point.z()});
  }
  const auto most = static_cast<std::size_t>(count);
  if (pixels.size() <= most) return pixels;
  std::vector<SelectedPixel> fewer;
  for (std::size_t k = 0; k < most; ++k) fewer.push_back(pixels[k * pixels.size() / most]);
  return fewer;
}

WindowKeyframe window_keyframe(const SavedMap& map, const Place& view,
                               const WindowOptions& window) {
  const Camera& camera = map.origin.camera;
  const KeyframePtr keyframe = keyframe_of(view);
  const Frame frame =
      make_frame({.stamp = view.stamp, .bgr = keyframe->bgr, .depth = keyframe->depth},
                 make_undistortion({.pinhole = camera}), 1);
  WindowKeyframe key = make_window_keyframe(
      frame, map.keyframes[static_cast<std::size_t>(view.id)].world_from_camera,
      refined_pixels(view, camera, window.points), window);
  key.id = view.id;
  return key;
}

}  // namespace

void refine_map(SavedMap& map, const WindowOptions& window, int threads) {
  if (window.final_iterations == 0) return;
  const Camera& camera = map.origin.camera;
  std::map<int, std::vector<WindowKeyframe>> segments;
  for (const Place& view : map.views)
    segments[map.keyframes[static_cast<std::size_t>(view.id)].segment].push_back(
        window_keyframe(map, view, window));
  std::map<KeyframeId, SE3> refined;
  for (auto& [segment, keyframes] : segments) {
    const JointOptions joint{.iterations = window.final_iterations, .threads = threads};
    refine_jointly(keyframes, keyframes_in_view(keyframes, camera, joint.neighbours), camera,
                   window, joint);
    for (const WindowKeyframe& key : keyframes) refined[key.id] = key.world_from_key;
  }
  std::map<int, SE3> corrections;  // of each segment's last one refined: world from old world
  for (MapKeyframe& key : map.keyframes) {
    SE3& correction = corrections[key.segment];
    const auto known = refined.find(key.id);
    if (known != refined.end()) correction = known->second * inverse(key.world_from_camera);
    key.world_from_camera = correction * key.world_from_camera;
  }
}

}  // namespace edvo
