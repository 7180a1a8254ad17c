// SPDX-License-Identifier: MIT
#include "edvo/report/recorder.hpp"

#include "edvo/report/html.hpp"

#include <fmt/core.h>

#include <utility>

namespace edvo {
namespace {

std::string tum_line(const StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_camera.translation;
  const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}", to_string(pose.stamp),
                     t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

std::string tum_text(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& pose : trajectory) text += tum_line(pose) + "\n";
  return text;
}

}  // namespace

Recorder::Recorder(std::filesystem::path folder, RunDescription run)
    : folder_(std::move(folder)),
      run_(std::move(run)),
      frames_(folder_ / "frames.jsonl"),
      trajectory_(folder_ / "trajectory.tum") {
  write_whole(folder_ / "config.toml", run_.config);
}

void Recorder::append(const FrameReport& report) {
  frames_.append(to_json_line(report));
  log_.frames.push_back({.index = report.index,
                         .stamp = report.stamp,
                         .status = report.status,
                         .keyframe = report.keyframe,
                         .inlier_ratio = static_cast<float>(report.inlier_ratio),
                         .overlap = static_cast<float>(report.overlap),
                         .milliseconds = report.milliseconds});
  if (report.status == FrameStatus::kLost) return;
  const StampedPose pose{.stamp = report.stamp, .world_from_camera = report.world_from_camera};
  trajectory_.append(tum_line(pose));
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
  write_whole(folder_ / "trajectory_online.tum", tum_text(log_.online));
  write_whole(folder_ / "trajectory.tum", tum_text(outcome.trajectory));
  write_whole(folder_ / "keyframes.tum", tum_text(outcome.keyframes));
  const RunSummary summary = summarize(run_, log_, outcome);
  write_whole(folder_ / "summary.json", to_json(summary));
  if (with_html) write_whole(folder_ / "report.html", to_html(summary, log_, outcome));
  return summary;
}

}  // namespace edvo
