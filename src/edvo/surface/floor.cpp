// SPDX-License-Identifier: MIT
#include "edvo/surface/floor.hpp"

#include "edvo/core/upper_median.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace edvo {
namespace {

constexpr int kStep = 8;       // [px] between the points that are looked at
constexpr int kReach = 4;      // [px] from a point to those that tell its normal
constexpr float kJump = 0.1F;  // of the depth, between these: no one surface

struct SurfacePoint {
  Eigen::Vector3d position, normal;  // in the world; the normal towards the camera, unit length
};

std::optional<SurfacePoint> surface_point(const DepthView& view, int x, int y) {
  const auto point = [&](int u, int v) {
    return back_project(view.camera, u, v, static_cast<double>(view.depth(v, u)));
  };
  const float z = view.depth(y, x);
  for (const auto& [dx, dy] :
       {std::pair(0, 0), {kReach, 0}, {-kReach, 0}, {0, kReach}, {0, -kReach}}) {
    const float other = view.depth(y + dy, x + dx);
    if (!(other > 0) || std::abs(other - z) > kJump * z) return std::nullopt;
  }
  const Eigen::Vector3d across = point(x + kReach, y) - point(x - kReach, y);
  const Eigen::Vector3d down = point(x, y + kReach) - point(x, y - kReach);
  Eigen::Vector3d normal = across.cross(down);
  if (!(normal.norm() > 0)) return std::nullopt;
  normal.normalize();
  if (normal.dot(point(x, y)) > 0) normal = -normal;
  return SurfacePoint{.position = view.world_from_camera * point(x, y),
                      .normal = view.world_from_camera.rotation * normal};
}

std::vector<SurfacePoint> surface_points(std::span<const DepthView> views) {
  std::vector<SurfacePoint> points;
  for (const DepthView& view : views)
    for (int y = kReach; y + kReach < view.depth.rows; y += kStep)
      for (int x = kReach; x + kReach < view.depth.cols; x += kStep)
        if (const auto point = surface_point(view, x, y)) points.push_back(*point);
  return points;
}

// A negative fy has the camera's y axis point up.
Eigen::Vector3d mean_image_top(std::span<const DepthView> views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const DepthView& view : views)
    sum += view.world_from_camera.rotation * Eigen::Vector3d(0, view.camera.fy > 0 ? -1 : 1, 0);
  return sum.norm() > 0 ? Eigen::Vector3d(sum.normalized()) : Eigen::Vector3d(0, -1, 0);
}

// The mean of the normals near the present one, taken again and again, from several starts: the one
// that most are near to.
std::optional<Eigen::Vector3d> common_normal(const std::vector<SurfacePoint>& points,
                                             const Eigen::Vector3d& about) {
  constexpr double kWithin = 0.7071, kNear = 0.966, kSame = 0.985;  // cosines of 45, 15, 10 degrees
  constexpr std::size_t kStarts = 64;
  constexpr int kRounds = 10;
  std::vector<Eigen::Vector3d> normals;
  for (const SurfacePoint& point : points)
    if (point.normal.dot(about) > kWithin) normals.push_back(point.normal);
  std::optional<Eigen::Vector3d> best;
  std::size_t most = 0;
  for (std::size_t start = 0; start < normals.size(); start += 1 + normals.size() / kStarts) {
    Eigen::Vector3d axis = normals[start];
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& normal : normals)
        if (normal.dot(axis) > (round < 3 ? kNear : kSame)) sum += normal;
      if (sum.norm() > 0) axis = sum.normalized();
    }
    const auto count = static_cast<std::size_t>(
        std::count_if(normals.begin(), normals.end(),
                      [&](const Eigen::Vector3d& normal) { return normal.dot(axis) > kSame; }));
    if (count <= most) continue;
    most = count;
    best = axis;
  }
  return best;
}

// The lowest height that many of the points that face up have.
std::optional<double> floor_height(const std::vector<SurfacePoint>& points,
                                   const Eigen::Vector3d& up) {
  constexpr double kFacesUp = 0.9;  // cosine
  constexpr double kLayer = 0.03;   // [m]
  constexpr double kLarge = 0.05;   // of the points of the fullest layers
  std::map<int, std::vector<double>> layers;
  for (const SurfacePoint& point : points)
    if (point.normal.dot(up) > kFacesUp) {
      const double height = point.position.dot(up);
      layers[static_cast<int>(std::floor(height / kLayer))].push_back(height);
    }
  const auto around = [&](int layer) {  // a floor may lie on the border of two
    std::size_t count = 0;
    for (int l = layer; l <= layer + 1; ++l)
      if (const auto found = layers.find(l); found != layers.end()) count += found->second.size();
    return count;
  };
  std::size_t most = 0;
  for (const auto& layer : layers) most = std::max(most, around(layer.first));
  for (const auto& layer : layers) {
    int fullest = layer.first;
    if (static_cast<double>(around(fullest)) < kLarge * static_cast<double>(most)) continue;
    while (around(fullest + 1) > around(fullest)) ++fullest;  // below it there is noise
    std::vector<double> heights;
    for (int l = fullest; l <= fullest + 1; ++l)
      if (const auto found = layers.find(l); found != layers.end())
        heights.insert(heights.end(), found->second.begin(), found->second.end());
    return upper_median(heights);
  }
  return std::nullopt;
}

}  // namespace

std::optional<Floor> find_floor(std::span<const DepthView> views,
                                const std::optional<Eigen::Vector3d>& up) {
  const std::vector<SurfacePoint> points = surface_points(views);
  const std::optional<Eigen::Vector3d> axis = up ? std::optional(Eigen::Vector3d(up->normalized()))
                                                 : common_normal(points, mean_image_top(views));
  if (!axis) return std::nullopt;
  const std::optional<double> height = floor_height(points, *axis);
  if (!height) return std::nullopt;
  return Floor{.up = *axis, .height = *height};
}

}  // namespace edvo
