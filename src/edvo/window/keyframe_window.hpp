// SPDX-License-Identifier: MIT
// The last keyframes of a segment and their joint refinement: the one header for callers.
#pragma once

#include "edvo/align/photometric.hpp"
#include "edvo/window/refinement.hpp"

namespace edvo {

// Keeps the images of at most keyframes + candidate_keyframes keyframes, fewer of places where many
// were taken. Not synchronized.
class KeyframeWindow {
 public:
  // Adds a keyframe, to be refined. id: by which refined() names it. from_last: brightness of the
  // frame against the last keyframe. pixels: its points, at most options.points of them.
  void add(std::int64_t id, const Frame& frame, const SE3& world_from_camera,
           const Alignment& from_last, const std::vector<SelectedPixel>& pixels,
           const WindowOptions& options);

  // Refines the keyframe added last together with those before it, held by older ones with the same
  // view: some steps at a time, to be called until nothing is left to do (false) or the next
  // keyframe is there.
  bool refine(const Camera& camera, double readout_seconds, const WindowOptions& options);

  struct Pose {
    std::int64_t id;  // of the keyframe, as given to add()
    SE3 world_from_camera;
  };
  // Of the keyframes that the last step moved or could have moved.
  [[nodiscard]] const std::vector<Pose>& refined() const { return refined_; }

  // All that are kept, the oldest first; to be changed only while no refinement is under way.
  [[nodiscard]] std::vector<WindowKeyframe>& keyframes() { return recent_; }

 private:
  void choose_members(const Camera& camera, const WindowOptions& options);
  void drop_one(const WindowOptions& options);

  std::vector<Pose> refined_;
  std::vector<WindowKeyframe> recent_;  // the last of them, bounded in number
  std::vector<PairModel> pairs_;        // as the last refinement left them
  bool waiting_ = false;                // the last keyframe has not been refined at all
  std::vector<std::size_t> members_;    // of recent_, the window of the refinement under way
  int fixed_ = 1;                       // the first so many members stay where they are
  Refinement refinement_;
};

}  // namespace edvo
