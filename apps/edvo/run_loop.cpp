// SPDX-License-Identifier: MIT
#include "run_loop.hpp"

#include "edvo/core/error.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/report/recorder.hpp"
#include "edvo/report/run_folder.hpp"
#include "progress.hpp"
#include "stop_signal.hpp"

#include <fmt/core.h>

#include <chrono>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

fs::path make_run_folder(const RunOptions& options, const std::string& sequence) {
  if (options.output.empty()) return make_stamped_run_folder("runs", sequence);
  make_named_run_folder(options.output, options.force);
  return options.output;
}

void skip(const InputFrame& frame, const std::string& reason, Recorder& recorder,
          Progress& progress) {
  recorder.append(
      SkippedFrame{.index = frame.index, .stamp = to_string(frame.stamp), .reason = reason});
  progress.say(fmt::format("warning: frame {} skipped: {}", frame.index, reason));
  progress.frame_skipped();
}

// The frame tracked; none if the odometry cannot use it, with the reason.
std::optional<FrameReport> process(Odometry& odometry, const InputFrame& frame,
                                   std::string& problem) {
  try {
    FrameReport report = odometry.process(*frame.image);
    report.index = frame.index;
    return report;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInput) throw;
    problem = error.what();
    return std::nullopt;
  }
}

// True if a signal ended it early.
bool track_all(const FrameSource& next_frame, Odometry& odometry, Recorder& recorder,
               Progress& progress) {
  const StopSignal signal;
  while (const std::optional<InputFrame> frame = next_frame()) {
    std::string problem = frame->problem;
    std::optional<FrameReport> report;
    if (frame->image) report = process(odometry, *frame, problem);
    if (report) {
      recorder.append(*report);
      progress.frame_done(*report);
    } else {
      skip(*frame, problem, recorder, progress);
    }
    if (stop_requested()) return true;
  }
  return false;
}

void evaluate_into(RunOutcome& outcome, const std::optional<GroundTruth>& truth, Recorder& recorder,
                   Progress& progress) {
  if (!truth) {
    outcome.no_evaluation = "no ground truth";
    return;
  }
  try {
    outcome.evaluation = evaluate_run(*truth, recorder.log(), outcome);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kEvaluation) throw;
    outcome.no_evaluation = fmt::format("{}: {}", truth->source, error.what());
    recorder.warn("no evaluation: " + outcome.no_evaluation);
    progress.say("warning: no evaluation: " + outcome.no_evaluation);
  }
}

// One pose is where the world begins, not a motion that was tracked.
void require_tracking(const RunResult& result) {
  const RunSummary& summary = result.summary;
  const auto due =
      summary.tracked + summary.lost + static_cast<std::int64_t>(summary.skipped.size());
  if (summary.tracked > 1 || (summary.tracked == 1 && due == 1) || summary.interrupted) return;
  throw Error(ErrorCode::kTrackingLost,
              fmt::format("{}: none of {} frames could be tracked ({} lost, {} skipped); what was "
                          "tried is in {}",
                          summary.run.source, due, summary.lost, summary.skipped.size(),
                          (result.folder / "frames.jsonl").string()));
}

}  // namespace

RunResult run_frames(const FrameSource& next_frame, const RunDescription& description,
                     const Config& config, const std::optional<GroundTruth>& truth,
                     const RunOptions& options) {
  Odometry odometry(description.camera, config);
  Recorder recorder(make_run_folder(options, description.sequence), description);
  Progress progress(description.frames, options.quiet);

  RunOutcome outcome;
  const auto start = std::chrono::steady_clock::now();
  outcome.interrupted = track_all(next_frame, odometry, recorder, progress);
  outcome.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.trajectory = odometry.trajectory();
  outcome.keyframes = odometry.keyframes();
  if (!outcome.trajectory.empty()) evaluate_into(outcome, truth, recorder, progress);

  const RunResult result{.summary = recorder.finish(outcome, !options.no_report),
                         .folder = recorder.folder()};
  require_tracking(result);
  return result;
}

}  // namespace edvo::app
