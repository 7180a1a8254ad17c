// SPDX-License-Identifier: MIT
#include "edvo/surface/make_grid.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

namespace edvo {
namespace {

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

// Rays at most half a cell apart [px], so that hardly a cell is left out where a surface is
// slanted.
int step_of(const DepthView& view, const GridOptions& options) {
  constexpr int kMost = 2;
  const double cell = options.resolution * ray_density(view, options.max_depth);  // [px]
  return std::clamp(static_cast<int>(cell / 2), 1, kMost);
}

template <typename Visitor>
void for_each_ray(const DepthView& view, const SE3& grid_from_map, const GridOptions& options,
                  const Visitor& visit) {
  const SE3 grid_from_camera = grid_from_map * view.world_from_camera;
  const int step = step_of(view, options);
  for (int y = 0; y < view.depth.rows; y += step)
    for (int x = 0; x < view.depth.cols; x += step) {
      const double z = static_cast<double>(view.depth(y, x));
      if (z > 0 && z <= options.max_depth)
        visit(grid_from_camera.translation, grid_from_camera * back_project(view.camera, x, y, z));
    }
}

// What was seen of one cell within one bin of heights.
struct Votes {
  std::uint16_t hits = 0, misses = 0;  // views
  std::uint8_t ends = 0;               // rays of the present view that end here
  bool is_passed = false;              // by one of them

  [[nodiscard]] bool is_touched() const { return ends > 0 || is_passed; }
};

// Heights above the floor: bin 0 is what can be driven over, the others are obstacles.
class HeightBins {
 public:
  explicit HeightBins(const GridOptions& options)
      : lowest_(options.lowest),
        highest_(options.highest),
        obstacles_(std::clamp(
            static_cast<int>(std::ceil((options.highest - options.lowest) / kHeight)), 1, kMost)) {}

  [[nodiscard]] int count() const { return 1 + obstacles_; }

  // Height in the middle of an obstacles' bin. [m]
  [[nodiscard]] double middle(int bin) const {
    return lowest_ + (bin - 0.5) / obstacles_ * (highest_ - lowest_);
  }

  // -1 outside.
  [[nodiscard]] int at(double height) const {
    if (height > highest_ || height <= -lowest_) return -1;
    if (height < lowest_) return 0;
    const double share = (height - lowest_) / (highest_ - lowest_);
    return 1 + std::min(static_cast<int>(share * obstacles_), obstacles_ - 1);
  }

 private:
  static constexpr double kHeight = 0.1;  // [m]
  static constexpr int kMost = 20;

  double lowest_, highest_;  // [m]
  int obstacles_;
};

class GridMaker {
 public:
  GridMaker(std::span<const DepthView> views, const Floor& floor, const GridOptions& options)
      : options_(options), bins_(options) {
    grid_.resolution = options.resolution;
    grid_.grid_from_map = grid_from_map(floor);
    Eigen::AlignedBox2d extent(Eigen::Vector2d::Zero());
    for (const DepthView& view : views)
      for_each_ray(view, grid_.grid_from_map, options,
                   [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
                     extent.extend(from.head<2>());
                     extent.extend(to.head<2>());
                   });
    allocate(extent);
    for (const DepthView& view : views) {
      for_each_ray(view, grid_.grid_from_map, options,
                   [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) { add(from, to); });
      count_view();
      const SE3 grid_from_camera = grid_.grid_from_map * view.world_from_camera;
      eyes_.push_back({.camera = view.camera,
                       .camera_from_grid = inverse(grid_from_camera),
                       .height = grid_from_camera.translation.z()});
    }
  }

  [[nodiscard]] OccupancyGrid take() {
    for (int y = 0; y < grid_.cells.rows; ++y)
      for (int x = 0; x < grid_.cells.cols; ++x)
        grid_.cells(y, x) = static_cast<std::uint8_t>(state_of({x, y}));
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
    grid_.cells.create(static_cast<int>(size.y()), static_cast<int>(size.x()));
    votes_.resize(grid_.cells.total() * static_cast<std::size_t>(bins_.count()));
  }

  [[nodiscard]] std::size_t first_bin(const cv::Point& cell) const {
    return static_cast<std::size_t>(cell.y * grid_.cells.cols + cell.x) *
           static_cast<std::size_t>(bins_.count());
  }

  // Where the votes for a point are; none outside the heights that matter.
  [[nodiscard]] std::optional<std::size_t> place_of(const Eigen::Vector3d& point) const {
    const int bin = bins_.at(point.z());
    if (bin < 0) return std::nullopt;
    const Eigen::Array2d cell =
        ((point.head<2>() - grid_.origin) / options_.resolution).array().floor();
    return first_bin({static_cast<int>(cell.x()), static_cast<int>(cell.y())}) +
           static_cast<std::size_t>(bin);
  }

  Votes& touch(std::size_t place) {
    if (!votes_[place].is_touched()) touched_.push_back(place);
    return votes_[place];
  }

  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    constexpr std::uint8_t kMost = 255;
    if (const auto end = place_of(to)) {
      Votes& votes = touch(*end);
      if (votes.ends < kMost) ++votes.ends;
    }
    // Depth has errors that grow with it: just in front of its end a ray says nothing.
    constexpr double kCertain = 0.99, kVerticalStep = 0.05;  // of the length; [m]
    const Eigen::Vector3d ray = kCertain * (to - from);
    const int steps = static_cast<int>(
        std::max(ray.head<2>().norm() / options_.resolution, std::abs(ray.z()) / kVerticalStep));
    for (int i = 0; i < steps; ++i)
      if (const auto place = place_of(from + (static_cast<double>(i) / steps) * ray))
        touch(*place).is_passed = true;
  }

  // Each view has one vote a bin: a ray that ends in it tells more than many that pass.
  void count_view() {
    constexpr std::uint16_t kMost = 65535;
    for (const std::size_t place : touched_) {
      Votes& votes = votes_[place];
      std::uint16_t& vote = votes.ends > 0 ? votes.hits : votes.misses;
      if (vote < kMost) ++vote;
      votes.ends = 0;
      votes.is_passed = false;
    }
    touched_.clear();
  }

  // Free needs to be seen down to the floor, as a ray above a table says nothing of the table, and
  // without a hidden height, as one below the table does not either.
  [[nodiscard]] CellState state_of(const cv::Point& cell) const {
    constexpr double kOccupied = 0.5, kFree = 0.35;  // of the views that say anything of a bin
    const std::size_t first = first_bin(cell);
    const Votes& floor = votes_[first];
    const Votes& lowest = votes_[first + 1];
    bool is_free = floor.hits + floor.misses + lowest.misses > 0;
    for (std::size_t bin = 1; bin < static_cast<std::size_t>(bins_.count()); ++bin) {
      const Votes& votes = votes_[first + bin];
      const double hits = votes.hits, all = hits + votes.misses;
      if (all == 0) {
        is_free = is_free && !is_hidden(cell, static_cast<int>(bin));
        continue;
      }
      if (hits >= kOccupied * all) return CellState::kOccupied;
      if (hits >= kFree * all) is_free = false;
    }
    return is_free ? CellState::kFree : CellState::kUnknown;
  }

  // Whether a bin of which no ray tells is where a camera above it looks: then something, or a gap
  // in its depth, keeps it from sight.
  [[nodiscard]] bool is_hidden(const cv::Point& cell, int bin) const {
    const Eigen::Vector2d middle =
        grid_.origin + options_.resolution * Eigen::Vector2d(cell.x + 0.5, cell.y + 0.5);
    const Eigen::Vector3d point(middle.x(), middle.y(), bins_.middle(bin));
    return std::any_of(eyes_.begin(), eyes_.end(), [&](const Eye& eye) {
      if (point.z() > eye.height) return false;
      const Eigen::Vector3d seen = eye.camera_from_grid * point;
      if (!(seen.z() > 0 && seen.z() <= options_.max_depth)) return false;
      const Eigen::Vector2d pixel = project(eye.camera, seen);
      return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= eye.camera.width - 1 &&
             pixel.y() <= eye.camera.height - 1;
    });
  }

  struct Eye {
    Camera camera;
    SE3 camera_from_grid;
    double height;  // above the floor [m]
  };

  GridOptions options_;
  HeightBins bins_;
  std::vector<Eye> eyes_;
  OccupancyGrid grid_;
  std::vector<Votes> votes_;  // of all bins of all cells
  std::vector<std::size_t> touched_;
};

}  // namespace

double ray_density(const DepthView& view, double depth) {
  return std::min(view.camera.fx, view.camera.fy) / depth;
}

OccupancyGrid make_grid(std::span<const DepthView> views, const Floor& floor,
                        const GridOptions& options) {
  return GridMaker(views, floor, options).take();
}

}  // namespace edvo
