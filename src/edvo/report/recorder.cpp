// SPDX-License-Identifier: MIT
#include "edvo/report/recorder.hpp"

#include "edvo/io/trajectory_file.hpp"
#include "edvo/report/html.hpp"
#include "edvo/report/markup.hpp"
#include "edvo/report/worst_frames.hpp"

#include <fmt/chrono.h>

#include <ctime>
#include <utility>

namespace edvo {

Recorder::Recorder(std::filesystem::path folder, RunDescription run, bool with_html)
    : folder_(std::move(folder)),
      run_(std::move(run)),
      with_html_(with_html),
      frames_(folder_ / "frames.jsonl"),
      trajectory_(folder_ / "trajectory.tum") {
  run_.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  write_whole(folder_ / "config.toml", run_.config);
}

void Recorder::frame(const FrameResult& report, const Frame& image) {
  frames_.append(to_json_line(report));
  log_.frames.push_back({.index = report.index,
                         .stamp = report.stamp,
                         .status = report.status,
                         .keyframe = report.keyframe_reason,
                         .inlier_ratio = static_cast<float>(report.inlier_ratio),
                         .overlap = static_cast<float>(report.overlap),
                         .milliseconds = report.milliseconds,
                         .finished = std::chrono::duration<double>(Clock::now() - begun_).count(),
                         .rms = static_cast<float>(report.rms),
                         .readout_seconds = static_cast<float>(report.readout_seconds),
                         .ego_share = static_cast<float>(report.ego_share),
                         .loss_cause = report.loss_cause,
                         .new_keyframe = report.new_keyframe.value_or(-1)});
  if (with_html_) pictures_.offer(report, image.bgr);
  if (report.status == FrameStatus::kLost) return;
  if (report.segment != segment_) trajectory_.append(segment_line(report.segment));
  segment_ = report.segment;
  trajectory_.append(
      trajectory_line({.stamp = report.stamp, .world_from_camera = report.world_from_camera}));
}

void Recorder::skipped(const SkippedFrame& skipped) {
  frames_.append(to_json_line(skipped));
  log_.skipped.push_back(skipped);
}

void Recorder::links(std::span<const LinkReport> links) {
  std::string lines;
  for (const LinkReport& link : links) {
    lines += to_json_line(link) + '\n';
    if (link.status == LinkStatus::kAccepted) log_.links.push_back({link.from, link.to});
  }
  write_whole(folder_ / "links.jsonl", lines);
}

void Recorder::warning(const std::string& text) {
  run_.warnings.push_back(text);
  log_.warnings.push_back({.frames_before = log_.frames.size(), .text = text});
}

void Recorder::end(const RunOutcome& outcome) {
  summary_ = summarize(run_, log_, outcome);  // known even if nothing of it can be written
  write_trajectory(folder_ / "trajectory_online.tum", outcome.online);
  write_trajectory(folder_ / "trajectory.tum", outcome.trajectory);
  write_trajectory(folder_ / "keyframes.tum", outcome.keyframes);
  if (outcome.evaluation) write_trajectory(folder_ / "groundtruth.tum", outcome.evaluation->truth);
  write_whole(folder_ / "summary.json", to_json(summary_));
  if (!with_html_) return;
  log_.worst = choose_worst_frames(log_, outcome.evaluation, pictures_.frames());
  for (WorstFrame& worst : log_.worst) worst.picture = base64(pictures_.jpeg_of(worst.frame));
  write_whole(folder_ / "report.html", to_html(summary_, log_, outcome));
}

}  // namespace edvo
