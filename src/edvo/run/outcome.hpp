// SPDX-License-Identifier: MIT
// What is known at the end of a run.
#pragma once

#include "edvo/core/error.hpp"
#include "edvo/core/trajectory.hpp"
#include "edvo/odometry/frame_result.hpp"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

// A frame that could not be read or used.
struct SkippedFrame {
  std::int64_t index = 0;
  std::string stamp;
  std::string reason;
};

// Every frame that was asked for is in one of the first five, but the one whose error ended the
// run.
struct FrameCounts {
  std::int64_t tracked = 0;  // pose estimated, the first one included
  std::int64_t lost = 0;
  std::int64_t restarted = 0;  // pose guessed, a new segment begun
  std::int64_t skipped = 0;
  std::int64_t dropped = 0;  // of a live source: not read, as a newer one had come

  std::int64_t relocalized = 0;  // of those tracked: back in an earlier segment
  std::int64_t segments = 0;     // parts of the trajectory; no motion is known between two of them
  std::map<LossCause, std::int64_t> causes;  // of the frames lost
};

// Counts a frame that was processed.
void add_to(FrameCounts& counts, const FrameResult& result);

[[nodiscard]] std::int64_t frames_processed(const FrameCounts& counts);

// Processed or skipped: those that could have got a pose.
[[nodiscard]] std::int64_t frames_due(const FrameCounts& counts);

// A measured value over time. A NaN interrupts it.
struct Curve {
  std::vector<double> seconds;  // [s] since the first frame
  std::vector<double> values;
};

// How far one trajectory is from ground truth.
struct TrajectoryErrors {
  double ate = 0, ate_median = 0, ate_max = 0;  // root mean square, median, largest [m]
  double rpe_translation = 0;                   // root mean square over 1 s [m/s]
  double rpe_rotation = 0;                      // root mean square over 1 s [deg/s]
  std::optional<double> drift;                  // end error per path length [%]
  std::int64_t ate_pairs = 0, rpe_pairs = 0;    // without pairs there is no error
  Curve ate_curve;                              // [m]
  Curve rpe_translation_curve;                  // [m/s]
  Curve rpe_rotation_curve;                     // [deg/s]
};

struct RunEvaluation {
  std::string ground_truth;       // where it was read from
  std::string protocol;           // of all numbers, as one line
  TrajectoryErrors final_poses;   // of RunOutcome::trajectory
  TrajectoryErrors online_poses;  // of RunOutcome::online
  Trajectory truth;               // during the run, aligned to the trajectory
  double scale = 1;               // that fits the final poses to the ground truth best (Sim(3))
  double scaled_ate = 0;          // of the final poses with that scale [m]
  std::vector<std::string> warnings = {};  // what to know before a number is quoted
};

struct RunOutcome {
  FrameCounts counts;
  Stamp first_stamp;      // of the first frame that was processed
  Trajectory trajectory;  // after all refinement; see Odometry::trajectory() for what is left out
  Trajectory online;      // each pose in the map as known when its frame was processed, restarted
                          // ones too
  Trajectory keyframes;   // as known at the end
  std::optional<RunEvaluation> evaluation;
  std::string no_evaluation;   // why there is none
  double wall_seconds = 0;     // of the frames, from the first asked for to the last pose
  double finish_seconds = 0;   // of finish(): the last pass over the whole recording
  bool interrupted = false;    // by RunOptions::should_stop
  std::optional<Error> error;  // that ended the run: of source, tracker or an observer
};

// As half a sentence: "hardly a pixel has a depth in range".
[[nodiscard]] std::string explain(LossCause cause);

// Why the run is a failure, with what it left as its result: the error that ended it, or
// Error(kTrackingLost), with the most frequent cause, if no motion was tracked. source: named in
// the message.
[[nodiscard]] std::optional<Error> failure_of(const RunOutcome& outcome, const std::string& source);

}  // namespace edvo
