// SPDX-License-Identifier: MIT
// The interface of whatever watches a run: records it, displays it, passes it on.
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
// goes on when they return. What they throw ends the run, which keeps its results so far, and is
// its outcome's error; what begin() throws passes through run().
class Observer {
 public:
  virtual ~Observer() = default;

  // Before the first frame.
  virtual void begin(const SourceInfo& /*source*/) {}

  // A frame was processed, whatever its status, lost ones included. image: what prepare() made of
  // it; its pixels may be kept, they are never written again.
  virtual void frame(const FrameResult& /*result*/, const Frame& /*image*/) {}

  // A frame could not be read, has the wrong size or type, or is not later than the one before.
  virtual void skipped(const SkippedFrame& /*frame*/) {}

  // The frame just told became a keyframe; also the first one of a segment. Only observers whose
  // wants_keyframes() is true are told: copying a keyframe's images costs time.
  [[nodiscard]] virtual bool wants_keyframes() const { return false; }
  virtual void keyframe(const KeyframePtr& /*keyframe*/) {}

  // Keyframes were added or moved: all of them, by id. After frame() and keyframe(), and once more
  // at the end if finish() moved some.
  virtual void map_changed(std::span<const MapKeyframe> /*keyframes*/) {}

  // What became of each pair of keyframes that might show the same place: once, after the last
  // frame, by trackers that look for some.
  virtual void links(std::span<const LinkReport> /*links*/) {}

  virtual void warning(const std::string& /*text*/) {}

  // The last call, after finish() and the evaluation; also of a run that was stopped or ended in an
  // error, even of this observer.
  virtual void end(const RunOutcome& /*outcome*/) {}

 protected:
  Observer() = default;
  Observer(const Observer&) = default;
  Observer& operator=(const Observer&) = default;
};

}  // namespace edvo
