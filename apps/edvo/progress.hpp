// SPDX-License-Identifier: MIT
// How far a run is: one line that is rewritten on a terminal, a line per tenth elsewhere.
#pragma once

#include "edvo/run/observer.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace edvo::app {

// Writes to stderr.
class Progress final : public Observer {
 public:
  explicit Progress(bool quiet);
  ~Progress() override;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void begin(const SourceInfo& source) override;
  void frame(const FrameResult& result, const Frame& image) override;

  // Warned of, also when quiet, but not by the hundred.
  void skipped(const SkippedFrame& frame) override;

  // A line of its own, whatever stands on the terminal. Shown also when quiet.
  void warning(const std::string& text) override;

 private:
  using Clock = std::chrono::steady_clock;

  void advance(bool is_last_word);
  void clear_line();
  [[nodiscard]] std::string line() const;

  std::optional<std::int64_t> frames_;  // none = not known
  bool quiet_;
  bool is_terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_shown_ = {};
  std::int64_t done_ = 0, lost_ = 0, skipped_ = 0, keyframes_ = 0;
  std::int64_t step_ = 0;  // last one shown: tenths of the run, or hundreds of frames
  std::string status_ = "-";
  double inlier_ratio_ = 0;  // [0..1]
  bool on_screen_ = false;
};

}  // namespace edvo::app
