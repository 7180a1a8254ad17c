// SPDX-License-Identifier: MIT
#include "edvo/report/recorder.hpp"

#include "edvo/io/trajectory_file.hpp"
#include "edvo/report/html.hpp"

#include <fmt/chrono.h>

#include <ctime>
#include <utility>

namespace edvo {

Recorder::Recorder(std::filesystem::path folder, RunDescription run)
    : folder_(std::move(folder)),
      run_(std::move(run)),
      frames_(folder_ / "frames.jsonl"),
      trajectory_(folder_ / "trajectory.tum") {
  run_.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  write_whole(folder_ / "config.toml", run_.config);
}

void Recorder::append(const FrameResult& report) {
  frames_.append(to_json_line(report));
  log_.frames.push_back({.index = report.index,
                         .stamp = report.stamp,
                         .status = report.status,
                         .keyframe = report.keyframe_reason,
                         .inlier_ratio = static_cast<float>(report.inlier_ratio),
                         .overlap = static_cast<float>(report.overlap),
                         .milliseconds = report.milliseconds,
                         .finished = std::chrono::duration<double>(Clock::now() - begun_).count()});
  if (report.status == FrameStatus::kLost) return;
  const StampedPose pose{.stamp = report.stamp, .world_from_camera = report.world_from_camera};
  trajectory_.append(trajectory_line(pose));
  log_.online.push_back(pose);
}

void Recorder::append(const SkippedFrame& skipped) {
  frames_.append(to_json_line(skipped));
  log_.skipped.push_back(skipped);
}

void Recorder::warn(const std::string& warning) {
  run_.warnings.push_back(warning);
}

RunSummary Recorder::finish(const RunOutcome& outcome, bool with_html) {
  write_trajectory(folder_ / "trajectory_online.tum", log_.online);
  write_trajectory(folder_ / "trajectory.tum", outcome.trajectory);
  write_trajectory(folder_ / "keyframes.tum", outcome.keyframes);
  const RunSummary summary = summarize(run_, log_, outcome);
  write_whole(folder_ / "summary.json", to_json(summary));
  if (with_html) write_whole(folder_ / "report.html", to_html(summary, log_, outcome));
  return summary;
}

}  // namespace edvo
