// SPDX-License-Identifier: MIT
#include "edvo/report/events.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>

namespace edvo {
namespace {

class EventList {
 public:
  explicit EventList(const Stamp& start) : start_(start) {}

  void add(EventKind kind, const FrameRecord& frame, std::string text) {
    events_.push_back({.kind = kind,
                       .frame = frame.index,
                       .seconds = seconds_between(start_, frame.stamp),
                       .text = std::move(text)});
  }

  [[nodiscard]] std::vector<RunEvent> sorted() {
    std::ranges::stable_sort(events_, {}, &RunEvent::frame);
    return std::move(events_);
  }

 private:
  Stamp start_;
  std::vector<RunEvent> events_;
};

void add_losses(const std::vector<FrameRecord>& frames, EventList& events) {
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i;
    while (end < frames.size() && frames[end].status == FrameStatus::kLost) ++end;
    if (end > i)
      events.add(EventKind::kLost, frames[i],
                 fmt::format("{} frame{}: {}", end - i, end - i == 1 ? "" : "s",
                             explain(frames[i].loss_cause)));
    i = std::max(end, i + 1);
  }
}

void add_links(const RunLog& log, EventList& events) {
  std::map<std::int64_t, const FrameRecord*> frame_of;  // by keyframe
  for (const FrameRecord& frame : log.frames)
    if (frame.new_keyframe >= 0) frame_of[frame.new_keyframe] = &frame;
  for (const KeyframeLink& link : log.links) {
    const auto earlier = frame_of.find(std::min(link.from, link.to));
    const auto later = frame_of.find(std::max(link.from, link.to));
    if (earlier == frame_of.end() || later == frame_of.end()) continue;
    events.add(EventKind::kLink, *later->second,
               fmt::format("sees the place of frame {}", earlier->second->index));
  }
}

}  // namespace

std::vector<RunEvent> events_of(const RunLog& log) {
  if (log.frames.empty()) return {};
  EventList events(log.frames.front().stamp);
  add_losses(log.frames, events);
  for (const FrameRecord& frame : log.frames) {
    if (frame.status == FrameStatus::kRestarted)
      events.add(EventKind::kRestarted, frame, "a new segment at a guessed pose");
    if (frame.status == FrameStatus::kRelocalized)
      events.add(EventKind::kRelocalized, frame, "back in an earlier segment");
  }
  add_links(log, events);
  for (const TimedWarning& warning : log.warnings)
    events.add(EventKind::kWarning,
               log.frames[std::min(warning.frames_before, log.frames.size() - 1)], warning.text);
  return events.sorted();
}

}  // namespace edvo
