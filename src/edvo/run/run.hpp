// SPDX-License-Identifier: MIT
// The loop: frames of a source, poses of a tracker, observers that watch.
#pragma once

#include "edvo/run/observer.hpp"
#include "edvo/run/outcome.hpp"
#include "edvo/run/tracker.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace edvo {

struct RunOptions {
  int threads = 2;  // one tracks, the others (4 at most) read ahead; results do not depend on it
  // Asked after each frame, and while a live source has none: true ends the run, whose results so
  // far are its results.
  std::function<bool()> should_stop = nullptr;
  std::optional<GroundTruth> ground_truth = {};  // to evaluate against; none = the source's
};

using Observers = std::vector<Observer*>;  // told in this order

// Tracks every frame of the source until its end, an error or a request to stop; then refines the
// last keyframes, takes the trajectories, and compares them with ground truth if there is any.
// Observers are told of each step as it happens, all from this thread. An Error(kInput) about a
// frame skips that frame; any other error of source or tracker ends the run and is in the outcome.
// So does what an observer throws, which is the outcome's error; the others are told of the end, as
// it is. Only what begin() throws is thrown.
RunOutcome run_tracker(RgbdSource& source, Tracker& tracker, const Observers& observers,
                       const RunOptions& options);

// tracker: an Odometry, or anything with its members.
template <typename T>
RunOutcome run(RgbdSource& source, T& tracker, const Observers& observers = {},
               const RunOptions& options = {}) {
  TrackerOf<T> adapter(tracker);
  return run_tracker(source, adapter, observers, options);
}

}  // namespace edvo
