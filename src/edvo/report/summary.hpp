// SPDX-License-Identifier: MIT
// What is known about a run: before it, frame by frame, and at its end.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/report/machine.hpp"
#include "edvo/run/outcome.hpp"
#include "edvo/slam/verify_link.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace edvo {

// Raised when a field of summary.json or frames.jsonl changes its meaning or goes.
inline constexpr int kSchemaVersion = 2;

// Known before the first frame.
struct RunDescription {
  std::string sequence;  // its name
  std::string source;    // where it was read from
  std::string command;   // exactly as given
  std::string started;   // UTC, ISO 8601
  std::string method;
  std::string config;  // resolved, TOML
  DistortedCamera camera;
  std::string camera_origin;  // which camera this is, and why it was taken
  double depth_scale = 0;     // [units per metre], 0 = depth came in metres
  std::string depth_origin;
  bool is_depth_assumed = false;       // no one said so: metres depend on it
  std::optional<std::int64_t> frames;  // in the sequence, or asked for; none = not known
  std::optional<std::uint64_t> seed;   // where something random took part
  std::vector<std::string> notes;      // what was found and chosen
  std::vector<std::string> warnings;   // what the user should look at
};

// The stages of a frame, in the order in which they run.
struct Stage {
  std::string_view name;
  double StageTimes::*time;
};
inline constexpr std::array<Stage, 6> kStages = {{{"frame", &StageTimes::frame},
                                                  {"edges", &StageTimes::edges},
                                                  {"corners", &StageTimes::corners},
                                                  {"selection", &StageTimes::selection},
                                                  {"tracking", &StageTimes::tracking},
                                                  {"window", &StageTimes::window}}};

// The little that is kept of each frame, whatever the length of the sequence.
struct FrameRecord {
  std::int64_t index = 0;
  Stamp stamp;
  FrameStatus status = FrameStatus::kLost;
  std::optional<KeyframeReason> keyframe;
  float inlier_ratio = 0, overlap = 0;  // [0..1]
  StageTimes milliseconds;
  double finished = 0;  // wall time since the run began [s]
  float rms = 0;        // photometric, of the inliers [grey levels]
  float readout_seconds = 0;
  float ego_share = 0;  // [0..1] of the image: moves along with the camera
  LossCause loss_cause = LossCause::kNone;
  std::int64_t new_keyframe = -1;  // that the frame became, -1 = none
};

// Two keyframes that show the same place, found and accepted.
struct KeyframeLink {
  std::int64_t from = 0, to = 0;
};

// What turned up on the way.
struct TimedWarning {
  std::size_t frames_before = 0;  // processed by then
  std::string text;
};

// A frame to look at, with its picture.
struct WorstFrame {
  std::int64_t frame = 0;  // index in the input
  double seconds = 0;      // since the first frame [s]
  std::string reason;      // one line
  std::string picture;     // JPEG in base64, empty = none
};

struct RunLog {
  std::vector<FrameRecord> frames;
  std::vector<SkippedFrame> skipped;
  std::vector<KeyframeLink> links = {};
  std::vector<TimedWarning> warnings = {};
  std::vector<WorstFrame> worst = {};  // the worst first
};

// Over all frames, also those in which the stage had nothing to do. [ms]
struct TimeStatistics {
  double mean = 0, median = 0, p95 = 0, p99 = 0;
};

struct RunSummary {
  RunDescription run;
  Machine machine;
  FrameCounts counts;
  std::int64_t lost_events = 0;  // runs of consecutive lost frames
  std::int64_t keyframes = 0;
  std::vector<SkippedFrame> skipped;
  double readout_seconds = 0;  // of a rolling shutter as estimated at the end, 0 = global
  double ego_share = 0;        // [0..1] the greatest of all frames
  double path_length = 0;      // of the trajectory as known at the end [m]
  double wall_seconds = 0;     // from the first frame asked for to the last pose
  double finish_seconds = 0;   // of the last pass, after that
  double peak_memory = 0;      // [MB]
  std::optional<std::int64_t> slowest_second = {};  // frames, see below
  bool interrupted = false;
  std::string error;  // that ended the run, empty = none
  std::optional<RunEvaluation> evaluation;
  std::string no_evaluation;
  double coverage = 0;  // [0..1] frames with a pose, of those that were due so far
  std::vector<TimeStatistics> stage_milliseconds = {};  // one per stage of kStages
  TimeStatistics total_milliseconds = {};               // of a whole frame, reading it excluded
};

// command: as given; config: resolved, TOML. The rest is the source's, but for `started`.
[[nodiscard]] RunDescription describe_run(const SourceInfo& source, const std::string& command,
                                          const std::string& method, const std::string& config);

[[nodiscard]] RunSummary summarize(const RunDescription& run, const RunLog& log,
                                   const RunOutcome& outcome);

// summary.json: one object, indented.
[[nodiscard]] std::string to_json(const RunSummary& summary);

// One line of frames.jsonl.
[[nodiscard]] std::string to_json_line(const FrameResult& report);
[[nodiscard]] std::string to_json_line(const SkippedFrame& skipped);
[[nodiscard]] std::string to_json_line(const LinkReport& link);

// The p-th quantile, p in [0..1], by linear interpolation; 0 of nothing.
[[nodiscard]] double quantile(std::vector<double> values, double p);

// Frames processed per second of the whole run, reading them included.
[[nodiscard]] double frames_per_second(const RunSummary& summary);

// Fewest frames that were finished in any second of wall time, from the start of the run or from
// the end of any frame on: what `frames_per_second` hides. None of a run shorter than a second.
[[nodiscard]] std::optional<std::int64_t> slowest_second(const std::vector<FrameRecord>& frames);

// Fingerprint of a resolved configuration (64-bit FNV-1a of the text, hexadecimal).
[[nodiscard]] std::string config_hash(std::string_view config);

}  // namespace edvo
