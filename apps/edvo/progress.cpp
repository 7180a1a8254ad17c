// SPDX-License-Identifier: MIT
#include "progress.hpp"
#include "terminal.hpp"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace edvo::app {
namespace {

constexpr std::chrono::milliseconds kRefresh{100};

std::string clock_time(double seconds) {
  const auto whole = static_cast<std::int64_t>(seconds + 0.5);
  if (whole >= 3600)
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::size_t terminal_width() {
  constexpr std::size_t kUsualWidth = 80;
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsualWidth;
  return size.ws_col;
}

}  // namespace

Progress::Progress(bool quiet) : quiet_(quiet), is_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  clear_line();
}

void Progress::begin(const SourceInfo& source) {
  frames_ = source.frames;
  start_ = Clock::now();
}

void Progress::frame(const FrameResult& result, const Frame& /*image*/) {
  status_ = std::string(name_of(result.status));
  inlier_ratio_ = result.inlier_ratio;
  if (result.status == FrameStatus::kLost) ++lost_;
  if (result.new_keyframe) ++keyframes_;
  ++done_;
  advance(done_ == frames_);
}

void Progress::skipped(const SkippedFrame& frame) {
  constexpr std::int64_t kMostWarnings = 3;  // a folder half empty must not flood the terminal
  ++skipped_;
  if (skipped_ <= kMostWarnings)
    warning(fmt::format("frame {} skipped: {}", frame.index, frame.reason));
  if (skipped_ == kMostWarnings) warning("should more be skipped, frames.jsonl will name them");
  ++done_;
  advance(done_ == frames_);
}

void Progress::warning(const std::string& text) {
  clear_line();
  say("warning: {}\n", text);
}

void Progress::advance(bool is_last_word) {
  if (quiet_) return;
  if (is_terminal_) {
    const Clock::time_point now = Clock::now();
    if (!is_last_word && now - last_shown_ < kRefresh) return;
    last_shown_ = now;
    // Wrapped lines cannot be rewritten.
    say_bytes(fmt::format("\r{}\x1b[K", line().substr(0, terminal_width() - 1)));
    on_screen_ = true;
    return;
  }
  constexpr std::int64_t kEvery = 100;  // frames, where there is no tenth
  const std::int64_t step =
      frames_ ? 10 * done_ / std::max<std::int64_t>(1, *frames_) : done_ / kEvery;
  if (step == step_) return;
  step_ = step;
  say("{}{}\n", frames_ ? fmt::format("{:3} %  ", 10 * step) : "", line());
}

void Progress::clear_line() {
  if (on_screen_) say_bytes("\r\x1b[K");
  on_screen_ = false;
}

std::string Progress::line() const {
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  const double rate = seconds > 0 ? static_cast<double>(done_) / seconds : 0;
  std::string text = fmt::format("frame {}", done_);
  if (frames_) text += fmt::format("/{}", *frames_);
  text += fmt::format("  {:.1f} fps", rate);
  if (frames_)
    text += fmt::format("  ETA {}",
                        clock_time(rate > 0 ? static_cast<double>(*frames_ - done_) / rate : 0));
  text +=
      fmt::format("  {}  inliers {:.0f} %  keyframes {}", status_, 100 * inlier_ratio_, keyframes_);
  if (lost_ > 0) text += fmt::format("  lost {}", lost_);
  if (skipped_ > 0) text += fmt::format("  skipped {}", skipped_);
  return text;
}

}  // namespace edvo::app
