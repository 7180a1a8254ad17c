// SPDX-License-Identifier: MIT
// The keyframes: all poses, and of the latest ones what their joint refinement needs.
#pragma once

#include "edvo/core/trajectory.hpp"
#include "edvo/odometry/config.hpp"
#include "edvo/track/window_refinement.hpp"

namespace edvo {

class LocalMap {
 public:
  // Adds a keyframe, to be refined. from_last: brightness of the frame against the last keyframe.
  void add(const Frame& frame, const SE3& world_from_camera, const Alignment& from_last,
           const std::vector<SelectedPixel>& pixels, const Config& config);

  // Refines the keyframe added last together with those before it, held by older ones with the same
  // view: some steps at a time, to be called until nothing is left to do (false) or the next
  // keyframe is there.
  bool refine(const Camera& camera, const WindowOptions& options);

  [[nodiscard]] const Trajectory& keyframes() const { return keyframes_; }

 private:
  void choose_members(const Camera& camera, const WindowOptions& options);

  Trajectory keyframes_;                // all
  std::vector<WindowKeyframe> recent_;  // the last of them, bounded in number
  std::vector<PairModel> pairs_;        // as the last refinement left them
  bool waiting_ = false;                // the last keyframe has not been refined at all
  std::vector<std::size_t> members_;    // of recent_, the window of the refinement under way
  int fixed_ = 1;                       // the first so many members stay where they are
  WindowRefinement refinement_;
};

// Candidates for tracking before corner optimization: H x W, 255 = edge; everything without
// detector.
// network: not null where the options ask for one.
[[nodiscard]] cv::Mat_<std::uint8_t> edge_mask(const Frame& frame, const Undistortion& undistortion,
                                               const EdgeDetector* network, const Config& config);

// Edges and the discs of the optimized corners (paper, fig. 3).
[[nodiscard]] cv::Mat_<std::uint8_t> with_corner_discs(const cv::Mat_<std::uint8_t>& edges,
                                                       const CornerOptions& options);

}  // namespace edvo
