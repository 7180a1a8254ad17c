// SPDX-License-Identifier: MIT
#include "edvo/slam/verify_link.hpp"

#include "edvo/core/random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr int kFreeSpaceStep = 8;     // [px] between the pixels that are tested
constexpr double kLeastError = 0.01;  // [m], [rad] of a motion
constexpr int kMostRadius = 6;        // [px]

std::vector<SelectedPixel> selected_pixels(const Keyframe& keyframe, const Camera& camera) {
  std::vector<SelectedPixel> pixels;
  pixels.reserve(keyframe.points.size());
  for (const ColoredPoint& point : keyframe.points) {
    const Eigen::Vector2d p = project(camera, point.position.cast<double>());
    pixels.push_back(
        {.pixel = {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))},
         .depth = point.position.z()});
  }
  return pixels;
}

std::uint64_t pair_seed(const LinkReport& report) {
  return mix(mix(static_cast<std::uint64_t>(report.from)) + static_cast<std::uint64_t>(report.to));
}

// Direct alignment in both directions; from_pose_to lies halfway between the two.
bool align_both_ways(const KeyframeView& from, const KeyframeView& to, const SE3& guess,
                     const AlignOptions& tracking, LinkReport& report) {
  report.status = LinkStatus::kNotAligned;
  const AlignResult forth =
      align(from.reference, to.frame, {.cur_from_ref = inverse(guess)}, tracking);
  if (forth.status != AlignStatus::kTracked) return false;
  const AlignResult back = align(to.reference, from.frame, {.cur_from_ref = guess}, tracking);
  if (back.status != AlignStatus::kTracked) return false;
  const SE3& to_pose_from = forth.alignment.cur_from_ref;
  const SE3 product = to_pose_from * back.alignment.cur_from_ref;
  report.translation_difference = product.translation.norm();
  report.rotation_difference = rotation_angle(product);
  report.from_pose_to = inverse(to_pose_from) * exp(0.5 * log(product));
  report.overlap = std::min(forth.overlap, back.overlap);
  report.correlation = std::min(forth.correlation, back.correlation);
  // Both see the same pixels: their information is not that of two measurements.
  const Matrix6d across = adjoint(inverse(to_pose_from));
  report.information = 0.5 * (across.transpose() * forth.information * across + back.information);
  return true;
}

// Where a viewer may look through a surface by error alone: of its depth and of the motion.
struct FreeSpaceTolerance {
  double inverse_depth = 0;  // [1 / m]
  double share = 0;          // of the inverse depth: scale errors of depth
  double translation = 0;    // [m]
  int radius = 1;            // [px] by which silhouettes may be off

  [[nodiscard]] double at(double inverse_z) const {
    return inverse_depth + inverse_z * (share + inverse_z * translation);
  }
};

// Whether any depth around a pixel is at most z.
bool is_any_as_near(const Depth& depth, int x, int y, int radius, double z) {
  const int left = std::max(0, x - radius), right = std::min(depth.cols() - 1, x + radius);
  const int top = std::max(0, y - radius), bottom = std::min(depth.rows() - 1, y + radius);
  for (int v = top; v <= bottom; ++v)
    for (int u = left; u <= right; ++u)
      if (const auto there = static_cast<double>(depth(v, u)); there > 0 && there <= z) return true;
  return false;
}

// Share of one keyframe's surface that the other looks through.
double seen_through(const Frame& surface, const Frame& viewer, const SE3& viewer_from_surface,
                    const FreeSpaceTolerance& tolerance) {
  const Camera& camera = viewer.levels.front().camera;
  int through = 0, same = 0;
  for (int y = kFreeSpaceStep / 2; y < surface.depth.rows(); y += kFreeSpaceStep)
    for (int x = kFreeSpaceStep / 2; x < surface.depth.cols(); x += kFreeSpaceStep) {
      const float z = surface.depth(y, x);
      if (!(z > 0)) continue;
      const Eigen::Vector3d p =
          viewer_from_surface * back_project(camera, x, y, static_cast<double>(z));
      if (p.z() < 0.1) continue;
      const Eigen::Vector2d pixel = project(camera, p);
      if (!(pixel.x() > 1 && pixel.y() > 1 && pixel.x() < camera.width - 2 &&
            pixel.y() < camera.height - 2))
        continue;
      const int u = static_cast<int>(std::lround(pixel.x()));
      const int v = static_cast<int>(std::lround(pixel.y()));
      const double measured = 1 / static_cast<double>(viewer.depth(v, u));
      const double limit = tolerance.at(1 / p.z());
      if (measured > 1 / p.z() + limit || !(measured > 0)) continue;  // hidden, or not measured
      const double least = 1 / p.z() - limit;
      if (least <= 0 || is_any_as_near(viewer.depth, u, v, tolerance.radius, 1 / least))
        ++same;
      else
        ++through;
    }
  return same + through > 0 ? static_cast<double>(through) / (same + through) : 1.0;
}

// By as much as the two directions disagree, and never by less than kLeastError.
FreeSpaceTolerance free_space_tolerance(const KeyframeView& view, const LinkReport& report,
                                        const LinkOptions& options) {
  const double translation = std::max(kLeastError, report.translation_difference);
  const double rotation = std::max(kLeastError, report.rotation_difference);
  const double pixels = view.frame.levels.front().camera.fx * rotation;
  return {.inverse_depth = options.depth_tolerance,
          .share = options.depth_share,
          .translation = translation,
          .radius = std::clamp(static_cast<int>(std::lround(pixels)), 1, kMostRadius)};
}

LinkStatus judge(const KeyframeView& from, const KeyframeView& to, const LinkOptions& options,
                 LinkReport& report) {
  if (report.translation_difference > options.max_translation_difference ||
      report.rotation_difference > options.max_rotation_difference)
    return LinkStatus::kDisagreement;
  if (report.overlap < options.min_overlap) return LinkStatus::kLittleOverlap;
  if (report.correlation < options.min_correlation) return LinkStatus::kLowCorrelation;
  const FreeSpaceTolerance tolerance = free_space_tolerance(from, report, options);
  report.seen_through =
      std::max(seen_through(to.frame, from.frame, report.from_pose_to, tolerance),
               seen_through(from.frame, to.frame, inverse(report.from_pose_to), tolerance));
  if (report.seen_through > options.max_seen_through) return LinkStatus::kSeenThrough;
  return LinkStatus::kAccepted;
}

}  // namespace

std::optional<SE3> motion_of_corners(const std::vector<CornerFeature>& from,
                                     const std::vector<CornerFeature>& to,
                                     const LinkOptions& options, LinkReport& report) {
  const std::vector<FeatureMatch> matches = match_features(to, from);
  report.matches = static_cast<int>(matches.size());
  report.status = LinkStatus::kFewMatches;
  if (report.matches < options.min_matches) return std::nullopt;
  const CornerMotion motion = estimate_motion(to, from, matches, pair_seed(report));
  report.inliers = static_cast<int>(motion.inliers.size());
  report.status = LinkStatus::kNoMotion;
  if (report.inliers < options.min_inliers) return std::nullopt;
  return motion.b_from_a;
}

KeyframeView make_view(const KeyframePtr& keyframe, const Frame& frame, const Camera& camera,
                       const AlignOptions& tracking) {
  KeyframeView view{.keyframe = keyframe, .frame = frame, .reference = {}};
  view.frame.shutter = keyframe->shutter;
  view.reference = make_reference(view.frame, selected_pixels(*keyframe, camera),
                                  {.gradient_weight_scale = tracking.gradient_weight_scale,
                                   .finest_level = tracking.finest_level,
                                   .coarsest_level = tracking.coarsest_level});
  if (tracking.depth_weight > 0)
    view.reference.surface =
        make_surface(keyframe->depth, camera, tracking.surface_cell, tracking.depth_noise);
  return view;
}

KeyframeView make_view(const KeyframePtr& keyframe, const Camera& camera,
                       const AlignOptions& tracking) {
  return make_view(
      keyframe,
      make_frame({.stamp = keyframe->stamp, .bgr = keyframe->bgr, .depth = keyframe->depth},
                 make_undistortion({.pinhole = camera}), tracking.coarsest_level + 1),
      camera, tracking);
}

LinkReport verify_link(const KeyframeView& from, const KeyframeView& to,
                       const std::optional<SE3>& guess, const AlignOptions& tracking,
                       const LinkOptions& options) {
  LinkReport report{.from = from.keyframe->id, .to = to.keyframe->id};
  const std::optional<SE3> motion =
      guess ? guess
            : motion_of_corners(describe_corners(from.frame, kFeaturesPerKeyframe),
                                describe_corners(to.frame, kFeaturesPerKeyframe), options, report);
  if (motion && align_both_ways(from, to, *motion, tracking, report))
    report.status = judge(from, to, options, report);
  return report;
}

}  // namespace edvo
