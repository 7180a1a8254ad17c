// SPDX-License-Identifier: MIT
#include "progress.hpp"

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

Progress::Progress(std::int64_t frames, bool quiet)
    : frames_(frames), quiet_(quiet), is_terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  clear_line();
}

void Progress::frame_done(const FrameResult& report) {
  status_ = std::string(name_of(report.status));
  inlier_ratio_ = report.inlier_ratio;
  if (report.status == FrameStatus::kLost) ++lost_;
  if (report.keyframe_reason) ++keyframes_;
  ++done_;
  advance(done_ == frames_);
}

void Progress::frame_skipped() {
  ++skipped_;
  ++done_;
  advance(done_ == frames_);
}

void Progress::say(std::string_view line) {
  clear_line();
  fmt::print(stderr, "{}\n", line);
}

void Progress::advance(bool is_last_word) {
  if (quiet_) return;
  if (is_terminal_) {
    const Clock::time_point now = Clock::now();
    if (!is_last_word && now - last_shown_ < kRefresh) return;
    last_shown_ = now;
    // Wrapped lines cannot be rewritten.
    fmt::print(stderr, "\r{}\x1b[K", line().substr(0, terminal_width() - 1));
    std::fflush(stderr);
    on_screen_ = true;
    return;
  }
  const std::int64_t tenths = frames_ > 0 ? 10 * done_ / frames_ : 0;
  if (tenths == tenths_) return;
  tenths_ = tenths;
  fmt::print(stderr, "{:3} %  {}\n", 10 * tenths, line());
}

void Progress::clear_line() {
  if (on_screen_) fmt::print(stderr, "\r\x1b[K");
  on_screen_ = false;
}

std::string Progress::line() const {
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  const double rate = seconds > 0 ? static_cast<double>(done_) / seconds : 0;
  const double left = rate > 0 ? static_cast<double>(frames_ - done_) / rate : 0;
  std::string text =
      fmt::format("frame {}/{}  {:.1f} fps  ETA {}  {}  inliers {:.0f} %  keyframes {}", done_,
                  frames_, rate, clock_time(left), status_, 100 * inlier_ratio_, keyframes_);
  if (lost_ > 0) text += fmt::format("  lost {}", lost_);
  if (skipped_ > 0) text += fmt::format("  skipped {}", skipped_);
  return text;
}

}  // namespace edvo::app
