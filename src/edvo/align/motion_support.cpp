// SPDX-License-Identifier: MIT
#include "edvo/align/motion_support.hpp"

#include "edvo/align/warp.hpp"
#include "edvo/simd/float8.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr int kLeastPoints = 3;       // of a cell, for its state
constexpr float kOtherDepth = 1.17F;  // times the expected one: not the same surface
constexpr double kExplained = 0.5;    // [0..1] of a cell's points

void add_intensity(const ReferenceLevel& points, const std::vector<float>& residuals, float limit,
                   const CellMask& hidden, MotionSupport& support) {
  std::array<int, kCellColumns * kCellRows> seen{}, fitting{};
  std::size_t in_view = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    if (std::isnan(residuals[i])) continue;
    const std::size_t cell = cell_of(points.camera, points.x[i], points.y[i], points.z[i]);
    ++in_view;
    ++seen[cell];
    fitting[cell] += std::abs(residuals[i]) < limit ? 1 : 0;
  }
  for (std::size_t cell = 0; cell < seen.size(); ++cell) {
    if (seen[cell] < kLeastPoints) continue;
    const double share = static_cast<double>(fitting[cell]) / seen[cell];
    support.states[cell] = share < kExplained ? CellState::kUnexplained : CellState::kExplained;
    support.intensity += share;
    ++support.cells;
    if (hidden[cell]) continue;
    support.intensity_behind += share;
    ++support.cells_behind;
  }
  support.intensity /= std::max(1, support.cells);
  support.intensity_behind /= std::max(1, support.cells_behind);
  support.in_view =
      static_cast<double>(in_view) / static_cast<double>(std::max<std::size_t>(1, points.count));
}

// Returns the cells that are hidden.
CellMask add_depth(const SurfacePoints& surface, const Camera& camera,
                   const DepthAssociations& associations, const SE3& cur_from_ref, float limit,
                   MotionSupport& support) {
  const Eigen::Matrix3f R = cur_from_ref.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f t = cur_from_ref.translation.cast<float>();
  std::array<int, kCells> in_front{};  // points that are nearer, less those that are not
  int fitting = 0, nearer = 0, farther = 0;
  for (std::size_t i = 0; i < surface.x.size(); ++i) {
    if (!(surface.z[i] > 0) || std::isnan(associations.z[i])) continue;
    const Eigen::Vector3f x(associations.x[i], associations.y[i], associations.z[i]);
    const Eigen::Vector3f normal(surface.nx[i], surface.ny[i], surface.nz[i]);
    const float error = (normal.dot(R.transpose() * (x - t)) - 1.F) / surface.z[i];
    const float expected =
        R.row(2).dot(Eigen::Vector3f(surface.x[i], surface.y[i], surface.z[i])) + t.z();
    ++support.depths;
    const bool is_nearer = associations.z[i] < expected / kOtherDepth;
    in_front[cell_of(camera, surface.x[i], surface.y[i], surface.z[i])] += is_nearer ? 1 : -1;
    nearer += is_nearer ? 1 : 0;
    farther += associations.z[i] > expected * kOtherDepth ? 1 : 0;
    fitting += std::abs(error) < limit ? 1 : 0;
  }
  const double all = std::max(1, support.depths);
  support.depth = fitting / all;
  support.nearer = nearer / all;
  support.farther = farther / all;
  CellMask hidden{};
  for (std::size_t cell = 0; cell < kCells; ++cell) hidden[cell] = in_front[cell] > 0;
  return hidden;
}

// Those of the kept points, padded again.
void keep(const std::vector<std::size_t>& kept, std::vector<float>& array) {
  std::vector<float> values(simd::padded(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) values[i] = array[kept[i]];
  array = std::move(values);
}

// The points in those cells for which the predicate holds.
template <typename Predicate>
Reference points_where(const Reference& reference, const Predicate& holds) {
  Reference part = reference;
  std::vector<std::size_t> kept;
  for (ReferenceLevel& level : part.levels) {
    if (level.count == 0) continue;
    kept.clear();
    for (std::size_t i = 0; i < level.count; ++i)
      if (holds(cell_of(level.camera, level.x[i], level.y[i], level.z[i]))) kept.push_back(i);
    for (std::vector<float>* array :
         {&level.x, &level.y, &level.z, &level.intensity, &level.weight})
      keep(kept, *array);
    for (std::vector<float>& array : level.jacobian) keep(kept, array);
    level.count = kept.size();
  }
  SurfacePoints& surface = part.surface;
  const Camera& camera = part.levels.front().camera;
  kept.clear();
  for (std::size_t i = 0; i < surface.x.size(); ++i)
    if (surface.z[i] > 0 && holds(cell_of(camera, surface.x[i], surface.y[i], surface.z[i])))
      kept.push_back(i);
  for (std::vector<float>* array :
       {&surface.x, &surface.y, &surface.z, &surface.nx, &surface.ny, &surface.nz})
    keep(kept, *array);
  return part;
}

}  // namespace

MotionSupport motion_support(const Reference& reference, const Frame& frame, int level,
                             const Alignment& alignment, const SupportLimits& limits,
                             AlignScratch& scratch) {
  const auto l = static_cast<std::size_t>(level);
  MotionSupport support;
  const Camera& camera = frame.levels.front().camera;
  associate_depth(reference.surface, camera, frame.depth, alignment.cur_from_ref,
                  scratch.associations);
  const CellMask hidden = add_depth(reference.surface, camera, scratch.associations,
                                    alignment.cur_from_ref, limits.depth, support);
  photometric_residuals(reference.levels[l], frame.levels[l], frame.shutter.readout(), alignment,
                        scratch.residuals);
  add_intensity(reference.levels[l], scratch.residuals, limits.intensity, hidden, support);
  return support;
}

cv::Rect pixels_of(std::size_t cell, cv::Size size) {
  const int column = static_cast<int>(cell) % kCellColumns;
  const int row = static_cast<int>(cell) / kCellColumns;
  const cv::Point from(column * size.width / kCellColumns, row * size.height / kCellRows);
  const cv::Point to((column + 1) * size.width / kCellColumns, (row + 1) * size.height / kCellRows);
  return {from, to};
}

CellMask with_neighbours(const CellMask& mask) {
  CellMask wide{};
  for (int row = 0; row < kCellRows; ++row)
    for (int column = 0; column < kCellColumns; ++column) {
      if (!mask[static_cast<std::size_t>(row * kCellColumns + column)]) continue;
      for (int y = std::max(0, row - 1); y <= std::min(kCellRows - 1, row + 1); ++y)
        for (int x = std::max(0, column - 1); x <= std::min(kCellColumns - 1, column + 1); ++x)
          wide[static_cast<std::size_t>(y * kCellColumns + x)] = true;
    }
  return wide;
}

Reference points_in(const Reference& reference, const CellStates& states, CellState state) {
  return points_where(reference, [&](std::size_t cell) { return states[cell] == state; });
}

Reference points_outside(const Reference& reference, const CellStates& states, CellState state) {
  return points_where(reference, [&](std::size_t cell) { return states[cell] != state; });
}

CellMask moved_cells(const ReferenceLevel& points, const CellStates& states, CellState state,
                     const SE3& cur_from_ref) {
  const Camera& camera = points.camera;
  CellMask mask{};
  for (std::size_t i = 0; i < points.count; ++i) {
    if (states[cell_of(camera, points.x[i], points.y[i], points.z[i])] != state) continue;
    const Eigen::Vector3d moved =
        cur_from_ref * Eigen::Vector3f(points.x[i], points.y[i], points.z[i]).cast<double>();
    if (moved.z() < static_cast<double>(kNearest)) continue;
    const double u = camera.fx * moved.x() / moved.z() + camera.cx;
    const double v = camera.fy * moved.y() / moved.z() + camera.cy;
    if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) continue;
    const cv::Point cell = cell_at(camera, moved.x(), moved.y(), moved.z());
    mask[static_cast<std::size_t>(cell.y * kCellColumns + cell.x)] = true;
  }
  return with_neighbours(mask);
}

cv::Mat_<float> without_cells(const cv::Mat_<float>& depth, const CellMask& mask) {
  if (std::ranges::count(mask, true) == 0) return depth;
  cv::Mat_<float> rest = depth.clone();
  for (std::size_t cell = 0; cell < kCells; ++cell)
    if (mask[cell])
      rest(pixels_of(cell, depth.size())).setTo(std::numeric_limits<float>::quiet_NaN());
  return rest;
}

}  // namespace edvo
