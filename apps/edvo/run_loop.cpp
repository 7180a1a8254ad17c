// SPDX-License-Identifier: MIT
#include "run_loop.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/prefetch.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/odometry/odometry.hpp"
#include "edvo/report/recorder.hpp"
#include "edvo/report/run_folder.hpp"
#include "memory.hpp"
#include "progress.hpp"
#include "stop_signal.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <opencv2/core/utility.hpp>
#include <variant>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

fs::path make_run_folder(const RunOptions& options, const std::string& sequence) {
  if (options.output.empty()) return make_stamped_run_folder("runs", sequence);
  make_named_run_folder(options.output, options.force);
  return options.output;
}

// The frame tracked, or why there is none.
std::variant<FrameResult, Error> process(Odometry& odometry,
                                         const Prefetched<PreparedImage>& frame) {
  if (const Error* error = std::get_if<Error>(&frame.content)) return *error;
  try {
    return odometry.process(std::get<PreparedImage>(frame.content));
  } catch (const Error& error) {
    return error;
  }
}

void skip(const SkippedFrame& frame, Recorder& recorder, Progress& progress) {
  constexpr std::size_t kMostWarnings = 10;  // a folder half empty must not flood the terminal
  recorder.append(frame);
  const std::size_t count = recorder.log().skipped.size();
  if (count <= kMostWarnings)
    progress.say(fmt::format("warning: frame {} skipped: {}", frame.index, frame.reason));
  if (count == kMostWarnings)
    progress.say("warning: should more be skipped, frames.jsonl will name them");
  progress.frame_skipped();
}

using Warn = std::function<void(const std::string&)>;

// The network, with a memory if the options ask for one; null where the method needs none. Refers
// to warn.
std::unique_ptr<EdgeDetector> open_detector(const RunOptions& options, const Config& config,
                                            const Camera& camera, const Warn& warn) {
  const cv::Size size(camera.width, camera.height);
  if (config.edge.detector != Detector::kNetwork && options.edge_cache.empty()) return nullptr;
  if (options.edge_cache.empty())
    return make_strength_detector(open_network(config.network, size), config.network);
  if (config.edge.detector != Detector::kNetwork)
    throw Error(ErrorCode::kUsage,
                fmt::format("--edge-cache {}: method {} uses no network; leave the cache out or "
                            "choose --method cnn+corner",
                            options.edge_cache, method_name(options)));
  std::error_code error;
  fs::create_directories(options.edge_cache, error);
  if (error || ::access(options.edge_cache.c_str(), W_OK) != 0)
    throw Error(ErrorCode::kOutput,
                fmt::format("--edge-cache {}: cannot be written: {}", options.edge_cache,
                            error ? error.message() : std::strerror(errno)));
  return make_strength_detector(
      open_cached_network(
          config.network, size,
          {.folder = options.edge_cache, .warn = [&warn](const std::string& text) { warn(text); }}),
      config.network);
}

// True if a signal ended it early.
bool track_all(const FrameInput& input, Prefetch<PreparedImage>& frames, Odometry& odometry,
               Recorder& recorder, Progress& progress) {
  while (const std::optional<Prefetched<PreparedImage>> frame = frames.next()) {
    const std::int64_t index = input.first_index + static_cast<std::int64_t>(frame->index);
    std::variant<FrameResult, Error> result = process(odometry, *frame);
    if (FrameResult* report = std::get_if<FrameResult>(&result)) {
      report->index = index;
      recorder.append(*report);
      progress.frame_done(*report);
    } else {
      const Error& error = std::get<Error>(result);
      if (error.code() != ErrorCode::kInput) throw Error(error);
      skip({.index = index,
            .stamp = to_string(input.stamp_of(frame->index)),
            .reason = error.what()},
           recorder, progress);
    }
    if (stop_requested()) return true;
  }
  return false;
}

void evaluate_into(RunOutcome& outcome, const std::optional<GroundTruth>& truth, Recorder& recorder,
                   Progress& progress) {
  if (!truth) {
    outcome.no_evaluation = "no usable ground truth";
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

RunResult run_frames(const FrameInput& input, const RunDescription& description,
                     const Config& config, const std::optional<GroundTruth>& truth,
                     const RunOptions& options) {
  take_memory();
  cv::setNumThreads(std::max(1, options.threads - 1));  // one thread reads ahead
  Warn warn = [](const std::string&) {};
  Odometry odometry(description.camera, config,
                    open_detector(options, config, description.camera.pinhole, warn));
  Recorder recorder(make_run_folder(options, description.sequence), description);
  Progress progress(description.frames, options.quiet);
  warn = [&](const std::string& warning) {
    recorder.warn(warning);
    progress.say("warning: " + warning);
  };

  const StopSignal signal;  // also while the results are written
  RunOutcome outcome;
  const auto start = std::chrono::steady_clock::now();
  Prefetch frames([&](std::size_t i) { return odometry.prepare(input.read(i)); }, input.count,
                  {.threads = options.threads});
  outcome.interrupted = track_all(input, frames, odometry, recorder, progress);
  outcome.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  odometry.finish();
  outcome.trajectory = odometry.trajectory();
  outcome.keyframes = odometry.keyframe_trajectory();
  if (!outcome.trajectory.empty()) evaluate_into(outcome, truth, recorder, progress);

  const RunResult result{.summary = recorder.finish(outcome, !options.no_report),
                         .folder = recorder.folder()};
  require_tracking(result);
  return result;
}

}  // namespace edvo::app
