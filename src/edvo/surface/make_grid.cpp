// SPDX-License-Identifier: MIT
#include "edvo/surface/make_grid.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <vector>

namespace edvo {
namespace {

constexpr int kStep = 2;  // [px] between the rays

// z along up, x where the map's first camera looks, the floor at z = 0.
SE3 grid_from_map(const Floor& floor) {
  Eigen::Vector3d x = Eigen::Vector3d::UnitZ() - floor.up.z() * floor.up;
  if (x.norm() < 0.1) x = Eigen::Vector3d::UnitX() - floor.up.x() * floor.up;
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), floor.up.cross(x).transpose(), floor.up.transpose();
  return {.rotation = Eigen::Quaterniond(rotation).normalized(),
          .translation = Eigen::Vector3d(0, 0, -floor.height)};
}

template <typename Visitor>
void for_each_ray(const DepthView& view, const SE3& grid_from_map, double max_depth,
                  const Visitor& visit) {
  const SE3 grid_from_camera = grid_from_map * view.world_from_camera;
  for (int y = 0; y < view.depth.rows; y += kStep)
    for (int x = 0; x < view.depth.cols; x += kStep) {
      const double z = static_cast<double>(view.depth(y, x));
      if (z > 0 && z <= max_depth)
        visit(grid_from_camera.translation, grid_from_camera * back_project(view.camera, x, y, z));
    }
}

class GridMaker {
 public:
  GridMaker(std::span<const DepthView> views, const Floor& floor, const GridOptions& options)
      : options_(options) {
    grid_.resolution = options.resolution;
    grid_.grid_from_map = grid_from_map(floor);
    Eigen::AlignedBox2d extent(Eigen::Vector2d::Zero());
    for (const DepthView& view : views)
      for_each_ray(view, grid_.grid_from_map, options.max_depth,
                   [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
                     extent.extend(from.head<2>());
                     extent.extend(to.head<2>());
                   });
    allocate(extent);
    for (const DepthView& view : views) {
      for_each_ray(view, grid_.grid_from_map, options.max_depth,
                   [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) { add(from, to); });
      count_view();
    }
  }

  [[nodiscard]] OccupancyGrid take() {
    constexpr double kOccupied = 0.5, kFree = 0.35;  // of the views that say anything of a cell
    grid_.cells.create(hits_.size());
    for (int y = 0; y < hits_.rows; ++y)
      for (int x = 0; x < hits_.cols; ++x) {
        const double all = hits_(y, x) + misses_(y, x);
        const double share = all > 0 ? hits_(y, x) / all : -1;
        CellState state = CellState::kUnknown;
        if (share >= kOccupied) state = CellState::kOccupied;
        if (share >= 0 && share < kFree) state = CellState::kFree;
        grid_.cells(y, x) = static_cast<std::uint8_t>(state);
      }
    return std::move(grid_);
  }

 private:
  void allocate(const Eigen::AlignedBox2d& extent) {
    constexpr double kBorder = 2;  // cells
    const double r = options_.resolution;
    const Eigen::Array2d lowest = (extent.min() / r).array().floor() - kBorder;
    const Eigen::Array2d size = (extent.max() / r).array().ceil() + kBorder - lowest;
    if (!(size.prod() <= options_.max_cells))
      throw Error(ErrorCode::kResources,
                  fmt::format("the grid would have {:.0f} x {:.0f} cells; choose larger ones",
                              size.x(), size.y()));
    grid_.origin = r * lowest.matrix();
    const cv::Size cells(static_cast<int>(size.x()), static_cast<int>(size.y()));
    hits_ = cv::Mat_<int>(cells, 0);
    misses_ = cv::Mat_<int>(cells, 0);
    ends_ = cv::Mat_<std::uint8_t>(cells, std::uint8_t{0});
    passes_ = cv::Mat_<std::uint8_t>(cells, std::uint8_t{0});
  }

  [[nodiscard]] cv::Point cell_of(const Eigen::Vector3d& point) const {
    const Eigen::Array2d cell =
        ((point.head<2>() - grid_.origin) / options_.resolution).array().floor();
    return {static_cast<int>(cell.x()), static_cast<int>(cell.y())};
  }

  void mark(cv::Mat_<std::uint8_t>& image, const cv::Point& cell) {
    constexpr std::uint8_t kMost = 255;
    std::uint8_t& rays = image(cell);
    if (rays == 0 && ends_(cell) + passes_(cell) == 0) touched_.push_back(cell);
    if (rays < kMost) ++rays;
  }

  // Passes are counted only where the ray is within the heights that matter, or on the floor.
  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double height = to.z();
    const bool is_obstacle = height >= options_.lowest && height <= options_.highest;
    const cv::Point end = cell_of(to);
    if (is_obstacle) mark(ends_, end);
    if (std::abs(height) < options_.lowest) mark(passes_, end);
    const Eigen::Vector3d ray = to - from;
    const double length = ray.head<2>().norm();
    const int steps = static_cast<int>(length / options_.resolution);
    cv::Point last = end;
    for (int i = 0; i < steps; ++i) {
      const Eigen::Vector3d point = from + (static_cast<double>(i) / steps) * ray;
      if (point.z() < options_.lowest || point.z() > options_.highest) continue;
      const cv::Point cell = cell_of(point);
      if (cell == last || cell == end) continue;
      mark(passes_, cell);
      last = cell;
    }
  }

  // Each view has one vote a cell: a few rays that end in it tell more than many that pass.
  void count_view() {
    constexpr int kFew = 3;
    for (const cv::Point& cell : touched_) {
      if (ends_(cell) >= kFew)
        ++hits_(cell);
      else if (passes_(cell) > 0)
        ++misses_(cell);
      ends_(cell) = passes_(cell) = 0;
    }
    touched_.clear();
  }

  GridOptions options_;
  OccupancyGrid grid_;
  cv::Mat_<int> hits_, misses_;           // views
  cv::Mat_<std::uint8_t> ends_, passes_;  // rays of the present view
  std::vector<cv::Point> touched_;
};

}  // namespace

OccupancyGrid make_grid(std::span<const DepthView> views, const Floor& floor,
                        const GridOptions& options) {
  return GridMaker(views, floor, options).take();
}

}  // namespace edvo
