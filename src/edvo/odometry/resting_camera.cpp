// SPDX-License-Identifier: MIT
#include "edvo/odometry/resting_camera.hpp"

#include "edvo/core/upper_median.hpp"
#include "edvo/odometry/motion_judge.hpp"

#include <algorithm>
#include <cmath>

// Numbers are those of docs/adr/0014: chosen with benchmarks/moving.py on seeds 1 to 12 and
// bad_frames.py, and so that no frame of fr1/xyz, desk and ICL-NUIM kt3 changes.

namespace edvo {
namespace {

constexpr double kLeastFlow = 0.0005;  // [widths of the image] less makes no difference

// Of a cell: its mean residuals by the two motions tell if one is so many times the other.
constexpr int kLeastPoints = 3;
constexpr float kMostResidual = 30;  // [grey levels] that one counts as
constexpr float kLeastApart = 0.5;   // [grey levels]
constexpr float kClearlyLess = 0.85F;

// Of the cells that tell, and of all in view [0..1]. While a camera moves at most 0.18 of those
// that tell say that it rests; a third may be what moves along with it, as dirt on its lens does.
constexpr double kLeastShare = 0.4, kLeastSeen = 0.2;
constexpr int kLeastCells = 8;

// What stands still has depth that does; what is on the lens has that of the scene.
constexpr double kLeastDepth = 0.7;  // [0..1] of it fits, and no less than by the first motion
constexpr int kLeastDepths = 10;

// Fewer cells tell that something moves if all is behind it, and moves by the first motion: what a
// robot carries before its camera is in front.
constexpr double kSurelyStill = 0.85, kHardlyMoves = 0.6;  // [0..1] of the depth
constexpr float kBehind = 1.3F;                            // times the depth of the others

struct CellMeans {
  std::array<float, kCells> residual{};  // [grey levels]
  std::array<int, kCells> points{};
};

// By each of two motions.
std::array<CellMeans, 2> cell_means(const Reference& reference, const Frame& frame, int level,
                                    const std::array<Alignment, 2>& alignments,
                                    AlignScratch& scratch) {
  const ReferenceLevel& points = reference.levels[static_cast<std::size_t>(level)];
  const std::array<std::vector<float>*, 2> residuals = {&scratch.residuals,
                                                        &scratch.other_residuals};
  for (std::size_t k = 0; k < 2; ++k)
    photometric_residuals(points, frame.levels[static_cast<std::size_t>(level)],
                          frame.shutter.readout(), alignments[k], *residuals[k]);
  std::array<CellMeans, 2> means;
  for (std::size_t i = 0; i < points.count; ++i) {
    const std::size_t cell = cell_of(points.camera, points.x[i], points.y[i], points.z[i]);
    for (std::size_t k = 0; k < 2; ++k) {
      const float residual = std::abs((*residuals[k])[i]);
      if (std::isnan(residual)) continue;
      means[k].residual[cell] += std::min(residual, kMostResidual);
      ++means[k].points[cell];
    }
  }
  for (CellMeans& one : means)
    for (std::size_t cell = 0; cell < kCells; ++cell)
      one.residual[cell] /= static_cast<float>(std::max(1, one.points[cell]));
  return means;
}

struct Vote {
  int seen = 0, telling = 0, resting = 0;
  CellStates states{};  // kExplained: at rest
};

Vote count_votes(const CellMeans& moving, const CellMeans& still, double largest) {
  Vote vote;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (std::min(moving.points[cell], still.points[cell]) < kLeastPoints) continue;
    ++vote.seen;
    const auto [less, more] = std::minmax(moving.residual[cell], still.residual[cell]);
    if (less > kClearlyLess * more || more - less < kLeastApart) continue;
    ++vote.telling;
    if (still.residual[cell] > less || static_cast<double>(less) > largest) continue;
    ++vote.resting;
    vote.states[cell] = CellState::kExplained;
  }
  return vote;
}

float median_depth(std::vector<float> depths) {
  std::erase_if(depths, [](float z) { return !(z > 0); });
  if (depths.empty()) return 0;
  return upper_median(depths);
}

}  // namespace

RestTest test_rest(const AlignResult& first, const Reference& reference, const Frame& frame,
                   double largest, const AlignOptions& options, AlignScratch& scratch) {
  const int level = options.finest_level;
  if (first.status != AlignStatus::kTracked ||
      mean_flow(reference, level, first.alignment.cur_from_ref, SE3{}) < kLeastFlow)
    return {};
  Alignment rest = first.alignment;
  rest.cur_from_ref = SE3{};
  const auto [moving, still] =
      cell_means(reference, frame, level, {first.alignment, rest}, scratch);
  const Vote votes = count_votes(moving, still, largest);
  if (votes.resting < kLeastCells) return {};

  const Reference parts = points_in(reference, votes.states, CellState::kExplained);
  const MotionSupport at_rest = support_within(largest, parts, frame, rest, options, scratch);
  const MotionSupport by_first =
      support_within(largest, parts, frame, first.alignment, options, scratch);
  if (at_rest.depths < kLeastDepths || at_rest.depth < std::max(kLeastDepth, by_first.depth))
    return {};
  if (votes.resting < kLeastShare * votes.telling || votes.resting < kLeastSeen * votes.seen) {
    const Reference others = points_outside(reference, votes.states, CellState::kExplained);
    return {.contradicts =
                at_rest.depth > kSurelyStill && by_first.depth < kHardlyMoves &&
                median_depth(parts.surface.z) > kBehind * median_depth(others.surface.z)};
  }
  AlignOptions fine = options;
  fine.coarsest_level = level;
  const AlignResult aligned = align(parts, frame, rest, fine, scratch);
  if (aligned.status != AlignStatus::kTracked) return {};
  return {.alignment = aligned};
}

}  // namespace edvo
