// SPDX-License-Identifier: MIT
// Who watches a run: writes it down, shows it, hands it on.
#pragma once

#include "edvo/image/frame.hpp"
#include "edvo/map/keyframe.hpp"
#include "edvo/map/map.hpp"
#include "edvo/odometry/frame_result.hpp"
#include "edvo/run/outcome.hpp"
#include "edvo/slam/verify_link.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <span>
#include <string>

namespace edvo {

// Observers get values and cannot change a result. All calls come from the thread of run(), which
// goes on when they return. What they throw ends the run and passes through run().
class Observer {
 public:
  virtual ~Observer() = default;

  // Before the first frame.
  virtual void begin(const SourceInfo& /*source*/) {}

  // A frame was processed: tracked or lost. image: what it was made from; its pixels may be kept,
  // as they are never written again.
  virtual void frame(const FrameResult& /*result*/, const Frame& /*image*/) {}

  // A frame could not be read or used.
  virtual void skipped(const SkippedFrame& /*frame*/) {}

  // A frame became a keyframe. Told only who wants it: a keyframe with its images costs time.
  [[nodiscard]] virtual bool wants_keyframes() const { return false; }
  virtual void keyframe(const KeyframePtr& /*keyframe*/) {}

  // Keyframes came or moved, by refinement or a loop: all keyframes, by id.
  virtual void map_changed(std::span<const MapKeyframe> /*keyframes*/) {}

  // What became of each pair of keyframes that might show the same place: once, after the last
  // frame, by trackers that look for some.
  virtual void links(std::span<const LinkReport> /*links*/) {}

  virtual void warning(const std::string& /*text*/) {}

  // After the last frame, also of a run that was stopped or ended in an error.
  virtual void end(const RunOutcome& /*outcome*/) {}

 protected:
  Observer() = default;
  Observer(const Observer&) = default;
  Observer& operator=(const Observer&) = default;
};

}  // namespace edvo
