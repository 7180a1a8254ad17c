// SPDX-License-Identifier: MIT
// The keyframes: all poses, and of the latest ones what their joint refinement needs.
#pragma once

#include "edvo/align/photometric.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/window/refinement.hpp"

namespace edvo {

class KeyframeWindow {
 public:
  // Adds a keyframe, to be refined. from_last: brightness of the frame against the last keyframe.
  // pixels: its points, at most options.points of them.
  void add(const Frame& frame, const SE3& world_from_camera, const Alignment& from_last,
           const std::vector<SelectedPixel>& pixels, const WindowOptions& options);

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
  Refinement refinement_;
};

}  // namespace edvo
