// SPDX-License-Identifier: MIT
// How much of an image a motion explains, by area: an object with much texture counts for no more
// than the part of the image that it covers.
#pragma once

#include "edvo/align/align.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace edvo {

// An image in cells.
constexpr int kCellColumns = 16, kCellRows = 12;
constexpr std::size_t kCells = kCellColumns * kCellRows;

enum class CellState : std::uint8_t { kEmpty, kExplained, kUnexplained };

using CellStates = std::array<CellState, kCells>;
using CellMask = std::array<bool, kCells>;

// Column and row of the cell that a point projects to [m], or of the nearest. In a loop the factors
// are computed once.
[[nodiscard]] inline cv::Point cell_at(const Camera& camera, double x, double y, double z) {
  const double columns = static_cast<double>(kCellColumns) / camera.width;
  const double rows = static_cast<double>(kCellRows) / camera.height;
  const double near = 1 / z;
  return {
      std::clamp(static_cast<int>((camera.fx * x * near + camera.cx) * columns), 0,
                 kCellColumns - 1),
      std::clamp(static_cast<int>((camera.fy * y * near + camera.cy) * rows), 0, kCellRows - 1)};
}

[[nodiscard]] inline std::size_t cell_of(const Camera& camera, float x, float y, float z) {
  const cv::Point cell =
      cell_at(camera, static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
  return static_cast<std::size_t>(cell.y * kCellColumns + cell.x);
}

// Those of an image of this size, in pixels.
[[nodiscard]] cv::Rect pixels_of(std::size_t cell, cv::Size size);

// The cells of a mask and the eight around each.
[[nodiscard]] CellMask with_neighbours(const CellMask& mask);

// [0..1] of the image.
[[nodiscard]] inline double share_of(const CellMask& mask) {
  return static_cast<double>(std::ranges::count(mask, true)) / static_cast<double>(kCells);
}

struct SupportLimits {
  float intensity = 0;  // [grey levels] largest residual that fits
  float depth = 0;      // [1 / m] largest error of inverse depth that fits
};

// All of the reference image's cells, in which its points lie.
struct MotionSupport {
  double intensity = 0;  // [0..1] fitting points, mean over cells with points in view
  double depth = 0;      // [0..1] fitting points of the surface, of those that were measured
  int cells = 0;         // with points in view
  int depths = 0;        // points of the surface that were measured
  double nearer = 0, farther = 0;  // [0..1] of these, by a seventh or more than expected
  double in_view = 0;              // [0..1] of the reference's points
  // The same as intensity and cells, without cells that are hidden: most of their depth is nearer.
  double intensity_behind = 0;
  int cells_behind = 0;
  CellStates states{};  // by intensity
};

[[nodiscard]] MotionSupport motion_support(const Reference& reference, const Frame& frame,
                                           int level, const Alignment& alignment,
                                           const SupportLimits& limits, AlignScratch& scratch);

// The reference's points in cells of this state, and those in all others.
[[nodiscard]] Reference points_in(const Reference& reference, const CellStates& states,
                                  CellState state);
[[nodiscard]] Reference points_outside(const Reference& reference, const CellStates& states,
                                       CellState state);

// The cells of a frame that the reference's points of a level in cells of this state move to, with
// their neighbours.
[[nodiscard]] CellMask moved_cells(const ReferenceLevel& points, const CellStates& states,
                                   CellState state, const SE3& cur_from_ref);

// The same depth image, but with none in masked cells.
[[nodiscard]] cv::Mat_<float> without_cells(const cv::Mat_<float>& depth, const CellMask& mask);

}  // namespace edvo
