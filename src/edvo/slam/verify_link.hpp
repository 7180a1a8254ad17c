// SPDX-License-Identifier: MIT
// Whether two keyframes show the same place, and the motion between them: cheap tests first, each
// with a status that says why a candidate was refused.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/core/fields.hpp"
#include "edvo/features/corner_features.hpp"
#include "edvo/map/keyframe.hpp"

#include <array>
#include <concepts>
#include <optional>

namespace edvo {

enum class LinkStatus {
  kAccepted,
  kFewMatches,    // too few corners look alike
  kNoMotion,      // no rigid motion explains enough of them
  kNotAligned,    // direct alignment fails in one of the two directions
  kDisagreement,  // both directions give different motions
  kLittleOverlap,
  kLowCorrelation,
  kSeenThrough,  // one keyframe looks through what the other measured
  kCycle,        // contradicts the odometry and earlier links
  kKnown,        // true, but the map tells the same already
  kNotTried,     // others of the same keyframe have more matches
  kAlone,        // no second link joins the same two segments in the same way
};

template <>
struct EnumNames<LinkStatus> {
  static constexpr auto names = std::to_array<std::pair<LinkStatus, std::string_view>>({
      {LinkStatus::kAccepted, "accepted"},
      {LinkStatus::kFewMatches, "few_matches"},
      {LinkStatus::kNoMotion, "no_motion"},
      {LinkStatus::kNotAligned, "not_aligned"},
      {LinkStatus::kDisagreement, "disagreement"},
      {LinkStatus::kLittleOverlap, "little_overlap"},
      {LinkStatus::kLowCorrelation, "low_correlation"},
      {LinkStatus::kSeenThrough, "seen_through"},
      {LinkStatus::kCycle, "cycle"},
      {LinkStatus::kKnown, "known"},
      {LinkStatus::kNotTried, "not_tried"},
      {LinkStatus::kAlone, "alone"},
  });
};

struct LinkOptions {
  int min_matches = 15;
  int min_inliers = 9;
  double max_translation_difference = 0.06;  // [m]
  double max_rotation_difference = 0.05;     // [rad]
  double min_overlap = 0.3;                  // [0..1]
  double min_correlation = 0.6;              // [-1..1]
  double depth_tolerance = 0.03;             // [1 / m]
  double depth_share = 0.03;                 // [1]
  double max_seen_through = 0.1;             // [0..1]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, LinkOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("min_matches", self.min_matches, Range{3, 1e6}, "corners that look alike, at least");
  visit("min_inliers", self.min_inliers, Range{3, 1e6},
        "of them, those that one rigid motion explains, at least");
  visit("max_translation_difference", self.max_translation_difference, Range{0, 10},
        "between the alignments in both directions [m]");
  visit("max_rotation_difference", self.max_rotation_difference, Range{0, 3.2},
        "between the alignments in both directions [rad]");
  visit("min_overlap", self.min_overlap, Range{0, 1},
        "share of each keyframe's points that the other sees [0..1]");
  visit("min_correlation", self.min_correlation, Range{-1, 1},
        "of fitting points' intensities in both keyframes");
  visit("depth_tolerance", self.depth_tolerance, Range{1e-6, 10},
        "difference of inverse depths that counts as the same surface [1 / m]");
  visit("depth_share", self.depth_share, Range{0, 1}, "added to it: share of the inverse depth");
  visit("max_seen_through", self.max_seen_through, Range{0, 1},
        "share of pixels at which one keyframe looks through what the other measured [0..1]");
}

// A keyframe made ready to be compared with others.
struct KeyframeView {
  KeyframePtr keyframe;
  Frame frame;
  Reference reference;
};

[[nodiscard]] KeyframeView make_view(const KeyframePtr& keyframe, const Camera& camera,
                                     const AlignOptions& tracking);

// The same where the frame is there already.
[[nodiscard]] KeyframeView make_view(const KeyframePtr& keyframe, const Frame& frame,
                                     const Camera& camera, const AlignOptions& tracking);

// What was found out about a candidate; fields of steps that were not reached stay at zero.
struct LinkReport {
  std::int64_t from = 0, to = 0;  // keyframes
  LinkStatus status = LinkStatus::kFewMatches;
  double similarity = 0;  // of the places' codes [0..1], 0 = found by its pose
  int matches = 0, inliers = 0;
  double translation_difference = 0;  // of both directions [m]
  double rotation_difference = 0;     // [rad]
  double overlap = 0;                 // the smaller of both directions [0..1]
  double correlation = 0;             // the smaller of both directions
  double seen_through = 0;            // the larger of both directions [0..1]
  double alike = 0;                   // share of corners, the smaller; between segments [0..1]
  double cycle_chi_square = 0;
  SE3 from_pose_to;
  Matrix6d information = Matrix6d::Zero();  // of xi in from_pose_to * exp(xi)
};

// from_pose_to by the corners of both. Where there is none, the report's status says why; matches
// and inliers are filled in either case.
[[nodiscard]] std::optional<SE3> motion_of_corners(const std::vector<CornerFeature>& from,
                                                   const std::vector<CornerFeature>& to,
                                                   const LinkOptions& options, LinkReport& report);

// All steps but the cycle, which needs the pose graph. guess: from_pose_to, of which only the
// alignment is verified; without one, the corners give it.
[[nodiscard]] LinkReport verify_link(const KeyframeView& from, const KeyframeView& to,
                                     const std::optional<SE3>& guess, const AlignOptions& tracking,
                                     const LinkOptions& options);

}  // namespace edvo
