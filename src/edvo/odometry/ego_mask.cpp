// SPDX-License-Identifier: MIT
#include "edvo/odometry/ego_mask.hpp"

#include "edvo/core/inplace_vector.hpp"
#include "edvo/core/upper_median.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

// Numbers are those of docs/adr/0015: chosen with benchmarks/bad_frames.py, and so that nothing is
// found in the sequences named there.

namespace edvo {
namespace {

constexpr int kMostColumns = 160;  // of the small image: cells of about 10 x 10 pixels

// Variance [grey levels^2] of a cell that shows something, and the share of it that a difference
// between two images has where the cell shows something else.
constexpr float kContrast = 16, kOther = 0.5F;

// A difference as of a shift in the direction of least structure [pixels]: at rest, and moved. The
// least structure [grey levels^2 / pixel^2] keeps out cells with a straight edge, which may move
// along it.
constexpr float kRests = 0.3F, kMoves = 0.6F, kLeastStructure = 4;

// Cells that have changed, of those with contrast, for a frame to be counted.
constexpr int kLeastChanged = 6;
constexpr double kChangedShare = 0.1;

constexpr int kVotes = 2;      // frames that a cell has to rest in
constexpr int kMostVotes = 6;  // as many moves, less one per rest, and it is released

constexpr int kPause = 2;  // frames that are passed over while hardly any cell rests: it costs time

// Relative to the depth before: the same, and another one.
constexpr float kSameDepth = 0.03F, kOtherDepth = 0.08F;
constexpr float kNearer = 0.8F;  // than what changes: something carried, and no background

// Of the camera's own. A still camera, before which people walk, has up to 3 cells at rest that are
// taken for dirt, and for each cell that moves 0.25 or more of a background at rest.
constexpr int kLeastCells = 5;
constexpr double kDirtShare = 0.15;     // of other depth, of all cells at rest
constexpr double kFartherShare = 0.15;  // most of a background at rest, per cell that moves
constexpr double kMovesShare = 0.35;    // that move, of all with contrast

const cv::Mat_<std::uint8_t>& small_image(const Frame& frame) {
  std::size_t level = 0;
  while (level + 1 < frame.levels.size() && frame.levels[level].gray.cols > kMostColumns) ++level;
  return frame.levels[level].gray;
}

struct Difference {
  float contrast = 0;     // the greater variance of both images [grey levels^2]
  float change = 0;       // mean square of their difference without its mean [grey levels^2]
  bool is_other = false;  // nothing of the first is seen in the second
};

Difference compare(const cv::Mat_<std::uint8_t>& a, const cv::Mat_<std::uint8_t>& b,
                   const cv::Rect& cell) {
  int sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (int y = cell.y; y < cell.y + cell.height; ++y) {
    const std::uint8_t *row_a = a[y] + cell.x, *row_b = b[y] + cell.x;
    for (int x = 0; x < cell.width; ++x) {
      const int p = row_a[x], q = row_b[x];
      sum_a += p;
      sum_b += q;
      aa += p * p;
      bb += q * q;
      ab += p * q;
    }
  }
  const float n = static_cast<float>(cell.area());
  const float mean_a = static_cast<float>(sum_a) / n, mean_b = static_cast<float>(sum_b) / n;
  const float of_a = static_cast<float>(aa) / n - mean_a * mean_a;
  const float of_b = static_cast<float>(bb) / n - mean_b * mean_b;
  const float of_both = static_cast<float>(ab) / n - mean_a * mean_b;
  Difference difference = {.contrast = std::max(of_a, of_b), .change = of_a + of_b - 2 * of_both};
  difference.is_other = difference.change > kOther * (of_a + of_b);
  return difference;
}

// The lesser eigenvalue of the cell's mean structure tensor [grey levels^2 / pixel^2]: how much it
// changes per pixel of shift, in the direction in which it changes least (Shi and Tomasi).
float structure(const cv::Mat_<std::uint8_t>& image, const cv::Rect& cell) {
  float xx = 0, xy = 0, yy = 0;
  for (int y = cell.y; y + 1 < cell.y + cell.height; ++y) {
    const std::uint8_t *row = image[y] + cell.x, *next = image[y + 1] + cell.x;
    for (int x = 0; x + 1 < cell.width; ++x) {
      const int p = row[x], right = row[x + 1], below = next[x], across = next[x + 1];
      const float dx = 0.5F * static_cast<float>(right - p + across - below);
      const float dy = 0.5F * static_cast<float>(below - p + across - right);
      xx += dx * dx;
      xy += dx * dy;
      yy += dy * dy;
    }
  }
  const float n = static_cast<float>((cell.width - 1) * (cell.height - 1));
  const float mean = 0.5F * (xx + yy), apart = 0.5F * (xx - yy);
  return (mean - std::sqrt(apart * apart + xy * xy)) / n;
}

// Median of a cell's depth [m]; 0: too little of it.
float median_depth(const Depth& depth, const cv::Rect& cell) {
  constexpr int kSide = 5, kLeast = 8;  // pixels
  InplaceVector<float, kSide * kSide> depths;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const float z = depth(cell.y + (2 * j + 1) * cell.height / (2 * kSide),
                            cell.x + (2 * i + 1) * cell.width / (2 * kSide));
      if (z > 0) depths.push_back(z);
    }
  if (depths.size() < kLeast) return 0;
  return upper_median(depths);
}

// What the cells show, in short.
struct Rest {
  CellMask at_rest{};   // in enough frames, and not yet known as the camera's own
  CellMask in_front{};  // of these, those nearer than what changes
  int nearer = 0, farther = 0, other = 0;  // at rest: of the same depth, and of another one
  int moved = 0, unclear = 0;              // with contrast
};

// Which cells are the camera's own. Where most of the image moves the camera does, and nothing of
// the scene can rest in the image; but a foreground at rest before a moving crowd looks like
// something carried, but for the rest of the background.
CellMask own_cells(const Rest& seen) {
  const int rests = seen.nearer + seen.farther + seen.other;
  if (seen.moved < kMovesShare * (seen.moved + seen.unclear)) return {};
  if (seen.other >= kLeastCells && seen.other > kDirtShare * rests) return seen.at_rest;
  if (seen.nearer >= kLeastCells && seen.farther < kFartherShare * seen.moved) return seen.in_front;
  return {};
}

}  // namespace

void EgoMask::begin(const cv::Mat_<std::uint8_t>& image, const Depth& depth) {
  image.copyTo(last_);
  image.copyTo(since_);
  for (std::size_t cell = 0; cell < kCells; ++cell)
    depth_[cell] = median_depth(depth, pixels_of(cell, depth.size()));
  votes_ = {};
}

std::optional<float> EgoMask::depth_of_change(const cv::Mat_<std::uint8_t>& image,
                                              const Depth& depth) const {
  int with_contrast = 0, changed = 0;
  InplaceVector<float, kCells> depths;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    if (cells_[cell]) continue;
    const Difference difference = compare(last_, image, pixels_of(cell, image.size()));
    if (difference.contrast < kContrast) continue;
    ++with_contrast;
    if (!difference.is_other) continue;
    ++changed;
    const float z = median_depth(depth, pixels_of(cell, depth.size()));
    if (z > 0) depths.push_back(z);
  }
  if (depths.empty() || changed < std::max<double>(kLeastChanged, kChangedShare * with_contrast))
    return std::nullopt;
  return upper_median(depths);
}

bool EgoMask::observe(const Frame& frame) {
  const cv::Mat_<std::uint8_t>& image = small_image(frame);
  if (last_.size() != image.size()) {
    begin(image, frame.depth);
    return false;
  }
  if (pause_ > 0) {
    --pause_;
    return false;
  }
  const std::optional<float> beyond = depth_of_change(image, frame.depth);
  if (!beyond) return false;
  image.copyTo(last_);

  Rest seen;
  int candidates = 0;  // cells at rest, if only in this frame
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    const cv::Rect pixels = pixels_of(cell, image.size());
    const Difference difference = compare(since_, image, pixels);
    const float least = difference.is_other ? 0 : structure(since_, pixels);
    const bool tells = least > kLeastStructure;
    const auto depth = [&] {
      return median_depth(frame.depth, pixels_of(cell, frame.depth.size()));
    };
    if (difference.is_other || (tells && difference.change > kMoves * kMoves * least)) {
      seen.moved += difference.contrast > kContrast;
      votes_[cell] = own_[cell] ? votes_[cell] - 1 : 0;
      own_[cell] = votes_[cell] > 0;
      image(pixels).copyTo(since_(pixels));
      depth_[cell] = depth();
    } else if (tells && difference.change < kRests * kRests * least) {
      votes_[cell] = std::min(votes_[cell] + 1, kMostVotes);
      if (own_[cell]) continue;
      ++candidates;
      if (votes_[cell] < kVotes) continue;
      seen.at_rest[cell] = true;
      const float z = depth();
      if (!(z > 0 && depth_[cell] > 0)) continue;
      const float change = std::abs(z - depth_[cell]) / depth_[cell];
      seen.other += change > kOtherDepth;
      if (change > kSameDepth) continue;
      seen.in_front[cell] = z < kNearer * *beyond;
      ++(seen.in_front[cell] ? seen.nearer : seen.farther);
    } else {
      seen.unclear += difference.contrast > kContrast;
    }
  }
  pause_ = candidates < kLeastCells ? kPause : 0;
  const CellMask found = own_cells(seen);
  for (std::size_t cell = 0; cell < kCells; ++cell) own_[cell] = own_[cell] || found[cell];
  const CellMask before = std::exchange(cells_, with_neighbours(own_));
  return before != cells_;
}

}  // namespace edvo
