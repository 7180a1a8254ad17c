// SPDX-License-Identifier: MIT
// Writes a run to its folder, frame by frame, so that whatever happens the results so far are
// there.
#pragma once

#include "edvo/io/output_file.hpp"
#include "edvo/report/pictures.hpp"
#include "edvo/report/summary.hpp"
#include "edvo/run/observer.hpp"

#include <chrono>
#include <filesystem>

namespace edvo {

class Recorder final : public Observer {
 public:
  // Starts frames.jsonl, trajectory.tum and config.toml in an existing folder. Like every other
  // member, throws Error(kOutput) naming the file that cannot be written.
  Recorder(std::filesystem::path folder, RunDescription run, bool with_html);

  // When this returns, the frame is on disk: a line in frames.jsonl and, unless it is lost, its
  // pose as known now in trajectory.tum.
  void frame(const FrameResult& result, const Frame& image) override;
  void skipped(const SkippedFrame& frame) override;

  // Writes links.jsonl.
  void links(std::span<const LinkReport> links) override;

  // For what turns up on the way.
  void warning(const std::string& text) override;

  // Puts the poses as known at the end in trajectory.tum (those known at the time go to
  // trajectory_online.tum) and adds keyframes.tum, summary.json, groundtruth.tum if there
  // is ground truth and, if wanted, report.html. Each file appears whole or stays as it was.
  void end(const RunOutcome& outcome) override;

  // After end().
  [[nodiscard]] const RunSummary& summary() const { return summary_; }

  [[nodiscard]] const RunLog& log() const { return log_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::time_point begun_ = Clock::now();
  std::filesystem::path folder_;
  RunDescription run_;
  bool with_html_;
  LineFile frames_;
  LineFile trajectory_;
  int segment_ = 0;  // of the last pose in the trajectory
  RunLog log_;
  PictureCandidates pictures_;  // for report.html
  RunSummary summary_;
};

}  // namespace edvo
