// SPDX-License-Identifier: MIT
#include "edvo/window/window_keyframe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr float kJump = 0.03F;  // difference of neighbouring depths / depth, beyond: not smooth
// Weight of a point's own measured depth beside what images tell: errors of neighbouring pixels'
// depths are alike, so it tells less than its noise says.
constexpr double kOwnDepth = 0.25;
// Difference / depth, up to which a point lies on what the other keyframe sees: not behind a wall.
constexpr double kSameSurface = 0.2;
constexpr double kTurned = 0.5;  // cosine between directions of view, below: nothing in common

// Whether a surface that a keyframe sees at a pixel shows a camera there the same side; true where
// its depth does not tell a plane.
bool faces(const WindowKeyframe& key, float u, float v, const Eigen::Vector3d& camera_centre,
           const Camera& camera) {
  constexpr float kApart = 6;     // [px]
  constexpr float kBent = 0.05F;  // share of inverse depth, beyond: no plane
  const auto at = [&](float du, float dv) {
    const float x = std::clamp(u + du, 0.F, static_cast<float>(key.gray.cols - 2));
    const float y = std::clamp(v + dv, 0.F, static_cast<float>(key.gray.rows - 2));
    return inverse_depth_at(key, x, y);
  };
  const float here = at(0, 0);
  const float left = at(-kApart, 0), right = at(kApart, 0), up = at(0, -kApart),
              down = at(0, kApart);
  const auto is_straight = [&](float a, float b) {  // false for NaN
    return std::abs(a + b - 2 * here) < kBent * here;
  };
  if (!is_straight(left, right) || !is_straight(up, down)) return true;
  // Inverse depth of a plane with points p, slope * p = 1, is slope * (x, y, 1).
  const Eigen::Vector3d ray = back_project(camera, u, v, 1.0);
  Eigen::Vector3d slope(camera.fx * static_cast<double>(right - left) / (2 * kApart),
                        camera.fy * static_cast<double>(down - up) / (2 * kApart), 0);
  slope.z() = static_cast<double>(here) - slope.dot(ray);
  return slope.dot(camera_centre) < 1;
}

}  // namespace

WindowKeyframe make_window_keyframe(const Frame& frame, const SE3& world_from_key,
                                    const std::vector<SelectedPixel>& pixels,
                                    const WindowOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  const cv::Mat_<float> depth = frame.depth.undistorted();
  WindowKeyframe key{
      .stamp = frame.stamp, .world_from_key = world_from_key, .shutter = frame.shutter};
  key.gray = gray;
  key.half_depth = cv::Mat_<std::uint16_t>::zeros((gray.rows + 1) / 2, (gray.cols + 1) / 2);
  constexpr float kMostSteps = std::numeric_limits<std::uint16_t>::max();
  for (int y = 2; y < gray.rows - 2; y += 2)
    for (int x = 2; x < gray.cols - 2; x += 2) {
      const float z = depth(y, x);
      bool smooth = true;
      for (const auto& [dx, dy] : {std::pair{-2, 0}, {2, 0}, {0, -2}, {0, 2}})
        smooth = smooth && std::abs(depth(y + dy, x + dx) - z) < kJump * z;
      const float steps = 1.F / (kInverseDepthStep * z) + 0.5F;
      if (smooth && steps <= kMostSteps)
        key.half_depth(y / 2, x / 2) = static_cast<std::uint16_t>(steps);
    }
  const float soft2 =
      static_cast<float>(options.gradient_weight_scale * options.gradient_weight_scale);
  for (const SelectedPixel& selected : pixels) {
    WindowPoint point{.u = static_cast<float>(selected.pixel.x),
                      .v = static_cast<float>(selected.pixel.y)};
    point.measured = point.inverse_depth = 1.0 / static_cast<double>(selected.depth);
    const double bias = options.depth_bias * point.measured;
    point.weight = kOwnDepth / (options.depth_noise * options.depth_noise + bias * bias);
    for (std::size_t k = 0; k < kPatchSize; ++k) {
      const int x = selected.pixel.x + static_cast<int>(kPatternX[k]);
      const int y = selected.pixel.y + static_cast<int>(kPatternY[k]);
      const float gx = 0.5F * static_cast<float>(gray(y, x + 1) - gray(y, x - 1));
      const float gy = 0.5F * static_cast<float>(gray(y + 1, x) - gray(y - 1, x));
      point.intensity[k] = gray(y, x);
      point.gradient_weight_scale[k] = soft2 / (soft2 + gx * gx + gy * gy);
    }
    key.points.push_back(point);
  }
  return key;
}

double shared_view(const WindowKeyframe& host, const WindowKeyframe& target, const Camera& camera) {
  const SE3 target_from_host = inverse(target.world_from_key) * host.world_from_key;
  if (target_from_host.rotation.toRotationMatrix()(2, 2) < kTurned) return 0;
  const Eigen::Vector3d target_centre = inverse(target_from_host).translation;
  int seen = 0, tried = 0;
  for (std::size_t i = 0; i < host.points.size(); i += 5) {
    const WindowPoint& point = host.points[i];
    const double z = 1 / point.inverse_depth;
    const Eigen::Vector3d x = target_from_host * back_project(camera, point.u, point.v, z);
    ++tried;
    if (x.z() < 0.5 * z || x.z() > 2 * z) continue;  // too different in scale to match patches
    const Eigen::Vector2d pixel = project(camera, x);
    if (!(pixel.x() > 3 && pixel.y() > 3 && pixel.x() < camera.width - 4 &&
          pixel.y() < camera.height - 4))
      continue;
    const auto there = static_cast<double>(
        inverse_depth_at(target, static_cast<float>(pixel.x()), static_cast<float>(pixel.y())));
    const bool is_other_surface = std::abs(there * x.z() - 1) > kSameSurface;  // false for NaN
    seen += !is_other_surface && faces(host, point.u, point.v, target_centre, camera) ? 1 : 0;
  }
  return tried > 0 ? static_cast<double>(seen) / tried : 0.0;
}

}  // namespace edvo
