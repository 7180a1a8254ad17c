// SPDX-License-Identifier: MIT
// The insides of Odometry: its state, and the steps of process() that change it.
#pragma once

#include "edvo/odometry/ego_mask.hpp"
#include "edvo/odometry/keyframe_policy.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/odometry/readout_time.hpp"
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

// A frame's pose, stored relative to its keyframe: when the keyframe moves, the frame follows.
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
  ReadoutTime readout;
  EgoMask ego;
  AlignScratch scratch;
  Frame current_frame;  // its memory serves the next one

  Map map;
  Segment segment;  // the present one; its keyframe is -1 before the first frame
  // The last one that was left and had a few tracked frames: the only one relocalize() tries.
  std::optional<Segment> left_segment;
  std::vector<WindowKeyframe> archive;  // of segments that nothing comes back to, for finish()
  std::vector<FrameLink> links;         // one per frame that was not lost
  std::vector<Successor> successors;    // of all keyframes, by id
  std::vector<int> tracked_segments;    // ids of segments in which a frame was tracked, ascending
  std::optional<Stamp> newest_stamp;    // of all images, lost ones too
  std::int64_t images = 0;              // so far
  int lost_in_a_row = 0;                // frames
  int segments = 0;                     // begun so far
  // What newest_keyframe() makes its images and points from.
  Frame keyframe_frame;
  std::vector<SelectedPixel> keyframe_pixels;

  void require_newer(const Stamp& stamp);
  [[nodiscard]] bool has_tracked(int segment_id) const;
  [[nodiscard]] KeyframePtr newest_keyframe(bool with_colour) const;

  // Leaves out what moves along with the camera, of the frame and of what it is aligned to.
  void leave_out_own(const Frame& frame);

  // Refines the present segment's window by a few steps and writes its keyframes' poses to the map;
  // false if nothing is left to do.
  bool refine_window();

  // Takes over poses and segments of all keyframes.
  void correct(std::span<const MapKeyframe> keyframes);

  // Refines all keyframes of each segment together.
  void refine_all(int threads);

  // Of a frame, by the present poses of its keyframe and of that one's successor.
  [[nodiscard]] SE3 world_from_camera(const FrameLink& link) const;

  // Makes this frame the first keyframe of a new segment, at the last good pose. If too little of
  // the frame can be tracked, returns false and changes the result alone.
  bool begin_segment(const Frame& frame, KeyframeReason reason, FrameResult& result);

  // Aligns a frame that the present segment lost to left_segment; if it fits there, that becomes
  // the present one, and the other is kept in its place if it had a few tracked frames.
  bool relocalize(Frame& frame, SegmentAlignment& alignment);

  // Links the frame to the present segment's keyframe and fills in the result.
  void record_tracked(const Frame& frame, const AlignResult& alignment, bool relocalized,
                      FrameResult& result);
  // Reports the last good pose; after max_lost_frames in a row begins a new segment, if it can.
  void lose_or_restart(const Frame& frame, LossCause cause, FrameResult& result);

  // Makes a keyframe of a frame whose pose is known: edges, corners, points, window. Later frames
  // are aligned to it. False, and nothing changed, if too little can be tracked.
  bool insert_keyframe(const Frame& frame, KeyframeReason reason, FrameResult& result);

 private:
  // Keeps what finish() needs of a segment that nothing comes back to.
  void archive_segment(Segment&& old);
  [[nodiscard]] std::vector<WindowKeyframe*> all_keyframes();
  // Whether something has come in front of what the last good frame saw.
  [[nodiscard]] bool is_view_hidden(const Frame& frame);
  // Makes the frame the reference keyframe of target.
  bool insert_into(Segment& target, const Frame& frame, const SE3& world_from_camera,
                   FrameResult& result);
};

void require_fitting(const RgbdImage& image, const Camera& camera);
[[nodiscard]] int level_count(const Config& config);
[[nodiscard]] std::unique_ptr<EdgeDetector> make_detector(const Config& config);
void describe(const AlignResult& alignment, FrameResult& result);

}  // namespace edvo
