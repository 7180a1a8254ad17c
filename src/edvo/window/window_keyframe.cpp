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

}  // namespace

WindowKeyframe make_window_keyframe(const Frame& frame, const SE3& world_from_key,
                                    const std::vector<SelectedPixel>& pixels,
                                    const WindowOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  const cv::Mat_<float> depth = frame.depth.undistorted();
  WindowKeyframe key{.stamp = frame.stamp, .world_from_key = world_from_key};
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
  int seen = 0, tried = 0;
  for (std::size_t i = 0; i < host.points.size(); i += 5) {
    const WindowPoint& point = host.points[i];
    const double z = 1 / point.inverse_depth;
    const Eigen::Vector3d x = target_from_host * back_project(camera, point.u, point.v, z);
    ++tried;
    if (x.z() < 0.5 * z || x.z() > 2 * z) continue;  // too different in scale to match patches
    const Eigen::Vector2d pixel = project(camera, x);
    seen += pixel.x() > 3 && pixel.y() > 3 && pixel.x() < camera.width - 4 &&
            pixel.y() < camera.height - 4;
  }
  return tried > 0 ? static_cast<double>(seen) / tried : 0.0;
}

}  // namespace edvo
