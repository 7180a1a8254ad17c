// SPDX-License-Identifier: MIT
// How far a run is: one line that is rewritten on a terminal, a line per tenth elsewhere.
#pragma once

#include "edvo/odometry/frame_result.hpp"

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace edvo::app {

// Writes to stderr.
class Progress {
 public:
  Progress(std::int64_t frames, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void frame_done(const FrameResult& report);
  void frame_skipped();

  // A line of its own, whatever stands on the terminal. Shown also when quiet.
  void say(std::string_view line);

 private:
  using Clock = std::chrono::steady_clock;

  void advance(bool is_last_word);
  void clear_line();
  [[nodiscard]] std::string line() const;

  std::int64_t frames_;
  bool quiet_;
  bool is_terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_shown_ = {};
  std::int64_t done_ = 0, lost_ = 0, skipped_ = 0, keyframes_ = 0;
  std::int64_t tenths_ = 0;
  std::string status_ = "-";
  double inlier_ratio_ = 0;  // [0..1]
  bool on_screen_ = false;
};

}  // namespace edvo::app
