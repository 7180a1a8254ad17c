// SPDX-License-Identifier: MIT
// The insides of Odometry: its state, and the steps of process() that change it.
#pragma once

#include "edvo/odometry/keyframe_policy.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/odometry/segment.hpp"

#include <chrono>
#include <optional>
#include <vector>

namespace edvo {

class Stopwatch {
 public:
  // Time since the last lap, [ms].
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// The pose of a frame hangs on its keyframe's.
struct FrameLink {
  Stamp stamp;
  KeyframeId keyframe = -1;
  SE3 keyframe_from_camera;
  bool is_guess = false;  // the frame began a segment at a guessed pose
};

// The keyframe that came after another one in its segment.
struct Successor {
  KeyframeId id = -1;      // -1: none came
  SE3 keyframe_from_this;  // as tracked, before any refinement
};

struct Odometry::State {
  State(const Config& config, Undistortion undistortion);

  Config config;
  Undistortion undistortion;
  std::unique_ptr<EdgeDetector> detector;
  KeyframePolicy policy;
  MovingObjectGuard guard;
  AlignScratch scratch;

  Map map;
  Segment segment;                      // in which frames are tracked
  std::optional<Segment> left;          // the last long one that was left, to come back to
  std::vector<WindowKeyframe> archive;  // of segments that are left for good
  std::vector<FrameLink> links;         // of all frames with a pose
  std::vector<Successor> successors;    // of all keyframes, by id
  std::vector<int> with_tracked;        // segments in which a frame was tracked, ascending
  std::optional<Stamp> newest;          // of all images
  std::int64_t images = 0;
  int lost_in_a_row = 0;  // frames
  int segments = 0;       // begun so far
  Frame keyframe_frame;   // of the newest keyframe, and its points
  std::vector<SelectedPixel> keyframe_pixels;

  void require_newer(const Stamp& stamp);
  [[nodiscard]] bool has_tracked(int segment_id) const;
  [[nodiscard]] KeyframePtr newest_keyframe() const;

  // Refines the window by some steps; false if nothing is left to do.
  bool refine();

  // Takes over poses and segments of all keyframes.
  void correct(std::span<const MapKeyframe> keyframes);

  // Refines all keyframes of each segment together.
  void refine_all(int threads);

  // Of a frame, by the present poses of its keyframe and of that one's successor.
  [[nodiscard]] SE3 world_from_camera(const FrameLink& link) const;

  // Begins a segment with this frame, where the last one ended. False, and nothing changed, if too
  // little of the frame can be tracked.
  bool begin(const Frame& frame, KeyframeReason reason, FrameResult& result);

  // Aligns a frame that was lost to the segment that was left; if it fits there, that becomes the
  // present one.
  bool relocalize(const Frame& frame, SegmentAlignment& alignment);

  void take(const Frame& frame, const AlignResult& alignment, bool relocalized,
            FrameResult& result);
  void lose(const Frame& frame, LossCause cause, FrameResult& result);

  // Makes a keyframe of a frame whose pose is known: edges, corners, points, window. False, and
  // nothing changed, if too little can be tracked.
  bool insert_keyframe(const Frame& frame, KeyframeReason reason, FrameResult& result);

 private:
  void leave(Segment&& old);
  [[nodiscard]] std::vector<WindowKeyframe*> all_keyframes();
  bool insert_into(Segment& target, const Frame& frame, const SE3& world_from_camera,
                   FrameResult& result);
};

void require_fitting(const RgbdImage& image, const Camera& camera);
[[nodiscard]] int level_count(const Config& config);
[[nodiscard]] std::unique_ptr<EdgeDetector> make_detector(const Config& config);
void describe(const AlignResult& alignment, FrameResult& result);

}  // namespace edvo
