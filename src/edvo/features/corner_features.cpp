// SPDX-License-Identifier: MIT
#include "edvo/features/corner_features.hpp"

#include "edvo/core/random.hpp"
#include "edvo/features/corners.hpp"
#include "edvo/simd/dispatch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

constexpr double kCornerWindow = 1.5;    // [px] Gaussian window of the structure tensor
constexpr float kLeastQuality = 0.002F;  // share of the strongest response
constexpr int kCell = 32;                // [px] corners are spread over cells of this size
constexpr float kPatchRadius = 0.06F;    // [m]
constexpr float kLeastRadius = 7.F, kMostRadius = 56.F;  // [px]
constexpr float kLevelRadius = 14.F;  // [px] a patch is read at the level where it has less
constexpr double kSmoothing = 1.5;    // [px] of each level
constexpr float kSpread = 0.45F;      // sigma of the pattern, in radii
constexpr float kJump = 0.04F;        // share of depth: foreground and background
constexpr int kMostDistance = 70;     // bits of a match
constexpr int kAlikeDistance = 45;    // bits; patches that have nothing in common differ by 128
constexpr int kLeastCorners = 20;     // of which a share is told
constexpr double kSecond = 0.85;      // a match is nearer than this times the second

struct PatternPair {
  cv::Point2f first, second;  // in radii
};

using Pattern = std::array<PatternPair, 256>;

Pattern make_pattern() {
  constexpr std::uint64_t kPatternSeed = 0xb21ef;
  Random random{kPatternSeed};
  const auto place = [&random] {
    while (true) {
      const cv::Point2f p(kSpread * random.normal(), kSpread * random.normal());
      if (p.dot(p) < 1.F) return p;
    }
  };
  Pattern pattern;
  for (PatternPair& pair : pattern) pair = {place(), place()};
  return pattern;
}

struct Candidate {
  int x = 0, y = 0;
  float response = 0;
};

bool is_peak(const cv::Mat_<float>& response, int y, int x) {
  const float here = response(y, x);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const float there = response(y + dy, x + dx);
      if (there > here || (there == here && (dy < 0 || (dy == 0 && dx < 0)))) return false;
    }
  return true;
}

// Peaks of the response, the strongest of every cell first, then the second of every cell, ...
std::vector<Candidate> spread_corners(const cv::Mat_<std::uint8_t>& gray, std::size_t count) {
  const cv::Mat_<float> response = min_eigenvalue(gray, kCornerWindow);
  double strongest = 0;
  cv::minMaxLoc(response, nullptr, &strongest);
  const float least = kLeastQuality * static_cast<float>(strongest);
  const int columns = gray.cols / kCell + 1;
  std::vector<std::vector<Candidate>> cells(
      static_cast<std::size_t>(columns * (gray.rows / kCell + 1)));
  const int border = static_cast<int>(kLeastRadius) + 1;
  for (int y = border; y < gray.rows - border; ++y)
    for (int x = border; x < gray.cols - border; ++x)
      if (response(y, x) > least && is_peak(response, y, x))
        cells[static_cast<std::size_t>(y / kCell * columns + x / kCell)].push_back(
            {x, y, response(y, x)});
  for (auto& cell : cells)
    std::stable_sort(cell.begin(), cell.end(), [](const Candidate& a, const Candidate& b) {
      return a.response > b.response;
    });
  std::vector<Candidate> chosen;
  for (std::size_t round = 0; chosen.size() < count; ++round) {
    bool any = false;
    for (const auto& cell : cells) {
      if (round >= cell.size() || chosen.size() >= count) continue;
      chosen.push_back(cell[round]);
      any = true;
    }
    if (!any) break;
  }
  return chosen;
}

// Of the nearest surface around a corner: at a jump the corner belongs to what is in front.
float corner_depth(const Depth& depth, int x, int y) {
  constexpr int kRadius = 2;
  float nearest = std::numeric_limits<float>::infinity();
  const float here = depth(y, x);
  for (int dy = -kRadius; dy <= kRadius; ++dy)
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      const float z = depth(y + dy, x + dx);
      if (z > 0 && z < nearest) nearest = z;
    }
  return here > 0 && here < (1 + kJump) * nearest ? here : nearest;
}

struct SmoothLevel {
  cv::Mat_<std::uint8_t> gray;
  float scale = 1;  // of level 0's pixels
};

std::vector<SmoothLevel> smooth_levels(const Frame& frame) {
  constexpr std::size_t kLevels = 3;
  std::vector<SmoothLevel> levels;
  for (std::size_t l = 0; l < std::min(kLevels, frame.levels.size()); ++l) {
    SmoothLevel level{.gray = {}, .scale = 1.F / static_cast<float>(1 << l)};
    cv::GaussianBlur(frame.levels[l].gray, level.gray, {}, kSmoothing);
    levels.push_back(level);
  }
  return levels;
}

// Nearest pixels of an image whose border goes on outside.
struct AnyPixel {
  const cv::Mat_<std::uint8_t>& gray;

  [[nodiscard]] int at(int x, int y) const {
    return gray(std::clamp(y, 0, gray.rows - 1), std::clamp(x, 0, gray.cols - 1));
  }
  static int nearest(float u) { return static_cast<int>(std::floor(u + 0.5F)); }
};

// The same of a patch that lies within the image, where it takes no care.
struct InnerPixel {
  const cv::Mat_<std::uint8_t>& gray;

  [[nodiscard]] int at(int x, int y) const { return gray(y, x); }
  static int nearest(float u) { return static_cast<int>(u + 0.5F); }
};

// Unit vector from a patch's middle to its centre of brightness.
template <typename Pixels>
cv::Point2f direction(const Pixels& pixels, float u, float v, float radius) {
  const int r = static_cast<int>(radius);
  const int x = Pixels::nearest(u), y = Pixels::nearest(v);
  int along_x = 0, along_y = 0;
  for (int dy = -r; dy <= r; ++dy) {
    const int half = static_cast<int>(std::sqrt(static_cast<float>(r * r - dy * dy)));
    int sum = 0;
    for (int dx = -half; dx <= half; ++dx) {
      const int value = pixels.at(x + dx, y + dy);
      along_x += dx * value;
      sum += value;
    }
    along_y += dy * sum;
  }
  const auto fx = static_cast<float>(along_x), fy = static_cast<float>(along_y);
  const float length = std::sqrt(fx * fx + fy * fy);
  return length > 0 ? cv::Point2f(fx / length, fy / length) : cv::Point2f(1, 0);
}

template <typename Pixels>
Descriptor describe_patch(const Pixels& pixels, float u, float v, float radius) {
  static const Pattern kPattern = make_pattern();
  const cv::Point2f axis = direction(pixels, u, v, radius);
  const auto value = [&](const cv::Point2f& p) {
    return pixels.at(Pixels::nearest(u + radius * (axis.x * p.x - axis.y * p.y)),
                     Pixels::nearest(v + radius * (axis.y * p.x + axis.x * p.y)));
  };
  Descriptor descriptor{};
  for (std::size_t i = 0; i < kPattern.size(); ++i)
    if (value(kPattern[i].first) < value(kPattern[i].second))
      descriptor[i / 64] |= std::uint64_t{1} << (i % 64);
  return descriptor;
}

Descriptor describe(const std::vector<SmoothLevel>& levels, const Candidate& corner, float radius) {
  std::size_t l = 0;
  while (l + 1 < levels.size() && radius * levels[l].scale > kLevelRadius) ++l;
  const SmoothLevel& level = levels[l];
  const float u = static_cast<float>(corner.x) * level.scale;
  const float v = static_cast<float>(corner.y) * level.scale;
  const float r = radius * level.scale, room = r + 1;
  const bool inside = u >= room && v >= room &&
                      u + room < static_cast<float>(level.gray.cols - 1) &&
                      v + room < static_cast<float>(level.gray.rows - 1);
  return inside ? describe_patch(InnerPixel{level.gray}, u, v, r)
                : describe_patch(AnyPixel{level.gray}, u, v, r);
}

float patch_radius(const Camera& camera, float z) {
  return std::clamp(std::abs(static_cast<float>(camera.fx)) * kPatchRadius / z, kLeastRadius,
                    kMostRadius);
}

}  // namespace

std::vector<CornerFeature> describe_corners(const Frame& frame, std::size_t count) {
  const Camera& camera = frame.levels.front().camera;
  const std::vector<SmoothLevel> levels = smooth_levels(frame);
  std::vector<CornerFeature> features;
  // Some have no depth.
  for (const Candidate& corner : spread_corners(frame.levels.front().gray, 2 * count)) {
    const float z = corner_depth(frame.depth, corner.x, corner.y);
    if (!std::isfinite(z)) continue;
    features.push_back(
        {.point = back_project(camera, corner.x, corner.y, static_cast<double>(z)).cast<float>(),
         .descriptor = describe(levels, corner, patch_radius(camera, z))});
    if (features.size() == count) break;
  }
  return features;
}

double alike_share(const std::vector<CornerFeature>& features, const Frame& frame,
                   const SE3& frame_from_features) {
  constexpr double kSurface = 0.06;  // [1 / m]
  const Camera& camera = frame.levels.front().camera;
  const std::vector<SmoothLevel> levels = smooth_levels(frame);
  const double border = static_cast<double>(kLeastRadius) + 1;
  int alike = 0, all = 0;
  for (const CornerFeature& feature : features) {
    const Eigen::Vector3d p = frame_from_features * feature.point.cast<double>();
    if (p.z() <= 0) continue;
    const Eigen::Vector2d pixel = project(camera, p);
    if (!(pixel.x() >= border && pixel.y() >= border && pixel.x() < camera.width - border &&
          pixel.y() < camera.height - border))
      continue;
    const Candidate at{.x = static_cast<int>(std::lround(pixel.x())),
                       .y = static_cast<int>(std::lround(pixel.y()))};
    const float z = corner_depth(frame.depth, at.x, at.y);
    if (!std::isfinite(z) || std::abs(1 / static_cast<double>(z) - 1 / p.z()) > kSurface) continue;
    const Descriptor seen = describe(levels, at, patch_radius(camera, static_cast<float>(p.z())));
    ++all;
    alike += distance(seen, feature.descriptor) < kAlikeDistance ? 1 : 0;
  }
  return all < kLeastCorners ? 0.0 : static_cast<double>(alike) / all;
}

int distance(const Descriptor& a, const Descriptor& b) {
  int bits = 0;
  for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(a[i] ^ b[i]);
  return bits;
}

namespace {

constexpr int kNone = 1000;  // more bits than there are

// Nearest and second nearest of the other keyframe.
struct Nearest {
  int first = kNone, second = kNone;
  std::size_t index = 0;
};

// Distances from one descriptor to many.
EDVO_CLONES void distances(const Descriptor& from, const CornerFeature* to, std::size_t count,
                           int* bits) {
  for (std::size_t k = 0; k < count; ++k) {
    const Descriptor& other = to[k].descriptor;
    int sum = 0;
    for (std::size_t i = 0; i < from.size(); ++i) sum += __builtin_popcountll(from[i] ^ other[i]);
    bits[k] = sum;
  }
}

void offer(int bits, std::size_t index, Nearest& nearest) {
  if (bits < nearest.first) {
    nearest.second = nearest.first;
    nearest.first = bits;
    nearest.index = index;
  } else if (bits < nearest.second) {
    nearest.second = bits;
  }
}

}  // namespace

std::vector<FeatureMatch> match_features(const std::vector<CornerFeature>& a,
                                         const std::vector<CornerFeature>& b) {
  std::vector<Nearest> of_a(a.size()), of_b(b.size());
  std::vector<int> bits(b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    distances(a[i].descriptor, b.data(), b.size(), bits.data());
    for (std::size_t k = 0; k < b.size(); ++k) {
      offer(bits[k], k, of_a[i]);
      offer(bits[k], i, of_b[k]);
    }
  }
  std::vector<FeatureMatch> matches;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Nearest& best = of_a[i];
    if (best.first > kMostDistance || best.first > kSecond * best.second) continue;
    if (of_b[best.index].index == i) matches.push_back({i, best.index});
  }
  return matches;
}

namespace {

constexpr int kTrials = 400;
constexpr double kPixelLimit = 8;     // [px at a focal length of 525] reprojection error
constexpr double kUsualFocal = 525;   // [px]
constexpr double kDepthLimit = 0.03;  // [1 / m] error of inverse depth
constexpr double kLeastSide = 0.1;    // [m] of a triangle
constexpr double kSideError = 0.05;   // share by which sides may differ
constexpr int kRefinements = 3;

struct Pairs {
  Eigen::Matrix3Xd a, b;
};

SE3 fit_motion(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  const Eigen::Matrix4d m = Eigen::umeyama(a, b, false);
  return {.rotation = Eigen::Quaterniond(Eigen::Matrix3d(m.topLeftCorner<3, 3>())).normalized(),
          .translation = m.topRightCorner<3, 1>()};
}

bool agrees(const Eigen::Vector3d& moved, const Eigen::Vector3d& seen) {
  if (moved.z() <= 0.05) return false;
  const Eigen::Vector2d shift = moved.head<2>() / moved.z() - seen.head<2>() / seen.z();
  return shift.norm() < kPixelLimit / kUsualFocal &&
         std::abs(1 / moved.z() - 1 / seen.z()) < kDepthLimit;
}

std::vector<int> inliers_of(const SE3& b_from_a, const Pairs& pairs) {
  const SE3 a_from_b = inverse(b_from_a);
  std::vector<int> inliers;
  for (int i = 0; i < pairs.a.cols(); ++i) {
    const Eigen::Vector3d a = pairs.a.col(i), b = pairs.b.col(i);
    if (agrees(b_from_a * a, b) && agrees(a_from_b * b, a)) inliers.push_back(i);
  }
  return inliers;
}

// Whether three pairs span triangles of the same shape, large enough to give a rotation.
bool congruent(const Pairs& pairs, const std::array<int, 3>& sample) {
  for (std::size_t k = 0; k < 3; ++k) {
    const int i = sample[k], j = sample[(k + 1) % 3];
    const double side_a = (pairs.a.col(i) - pairs.a.col(j)).norm();
    const double side_b = (pairs.b.col(i) - pairs.b.col(j)).norm();
    if (std::min(side_a, side_b) < kLeastSide) return false;
    if (std::abs(side_a - side_b) > kSideError * std::max(side_a, side_b)) return false;
  }
  const Eigen::Vector3d p = pairs.a.col(sample[1]) - pairs.a.col(sample[0]);
  const Eigen::Vector3d q = pairs.a.col(sample[2]) - pairs.a.col(sample[0]);
  return p.cross(q).norm() > kLeastSide * kLeastSide / 2;
}

SE3 fit_some(const Pairs& pairs, const std::vector<int>& which) {
  Eigen::Matrix3Xd a(3, which.size()), b(3, which.size());
  for (std::size_t i = 0; i < which.size(); ++i) {
    a.col(static_cast<Eigen::Index>(i)) = pairs.a.col(which[i]);
    b.col(static_cast<Eigen::Index>(i)) = pairs.b.col(which[i]);
  }
  return fit_motion(a, b);
}

}  // namespace

CornerMotion estimate_motion(const std::vector<CornerFeature>& a,
                             const std::vector<CornerFeature>& b,
                             const std::vector<FeatureMatch>& matches, std::uint64_t seed) {
  CornerMotion result;
  const auto count = static_cast<int>(matches.size());
  if (count < 3) return result;
  Pairs pairs{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count)};
  for (int i = 0; i < count; ++i) {
    pairs.a.col(i) = a[matches[static_cast<std::size_t>(i)].a].point.cast<double>();
    pairs.b.col(i) = b[matches[static_cast<std::size_t>(i)].b].point.cast<double>();
  }
  Random random{seed};
  std::vector<int> best;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::array<int, 3> sample = {random.below(count), random.below(count),
                                       random.below(count)};
    if (!congruent(pairs, sample)) continue;
    const SE3 motion = fit_some(pairs, {sample.begin(), sample.end()});
    std::vector<int> inliers = inliers_of(motion, pairs);
    if (inliers.size() > best.size()) best = std::move(inliers);
  }
  if (best.size() < 3) return result;
  for (int i = 0; i < kRefinements; ++i) {
    result.b_from_a = fit_some(pairs, best);
    std::vector<int> inliers = inliers_of(result.b_from_a, pairs);
    if (inliers.size() < 3) break;
    best = std::move(inliers);
  }
  for (const int i : best) result.inliers.push_back(matches[static_cast<std::size_t>(i)]);
  return result;
}

}  // namespace edvo
