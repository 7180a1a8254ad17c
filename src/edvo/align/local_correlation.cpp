// SPDX-License-Identifier: MIT
#include "edvo/align/local_correlation.hpp"

#include "edvo/align/motion_support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace edvo {
namespace {

constexpr int kLeastPoints = 8;        // of a cell
constexpr double kLeastVariance = 16;  // [grey levels^2] of their intensities in the reference
constexpr double kNoise = 4;           // [grey levels^2] the other image's is never less
constexpr int kLeastCells = 10;        // that tell

// Sums over the points of a cell.
struct Sums {
  double count = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void add(double x, double y) {
    ++count;
    a += x;
    b += y;
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  [[nodiscard]] double variance_of_a() const { return (aa - a * a / count) / count; }
  [[nodiscard]] double variance_of_b() const { return (bb - b * b / count) / count; }
  [[nodiscard]] double covariance() const { return (ab - a * b / count) / count; }
};

}  // namespace

double local_correlation(const Reference& reference, const Frame& frame, int level,
                         const Alignment& alignment, AlignScratch& scratch) {
  const auto l = static_cast<std::size_t>(level);
  const ReferenceLevel& points = reference.levels[l];
  photometric_residuals(points, frame.levels[l], frame.shutter.readout(), alignment,
                        scratch.residuals);
  std::array<Sums, kCells> sums;
  for (std::size_t i = 0; i < points.count; ++i) {
    if (std::isnan(scratch.residuals[i])) continue;
    const auto seen = static_cast<double>(points.intensity[i]);
    const double there =
        static_cast<double>(scratch.residuals[i]) + alignment.gain * seen + alignment.bias;
    sums[cell_of(points.camera, points.x[i], points.y[i], points.z[i])].add(seen, there);
  }
  int cells = 0;
  double total = 0;
  for (const Sums& cell : sums) {
    if (cell.count < kLeastPoints || cell.variance_of_a() < kLeastVariance) continue;
    ++cells;
    total += cell.covariance() /
             std::sqrt(cell.variance_of_a() * std::max(kNoise, cell.variance_of_b()));
  }
  return cells < kLeastCells ? 1.0 : total / cells;
}

}  // namespace edvo
