// SPDX-License-Identifier: MIT
// What happened in a run, and when.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/report/summary.hpp"

#include <string>
#include <vector>

namespace edvo {

enum class EventKind { kLost, kRestarted, kRelocalized, kLink, kWarning };

template <>
struct EnumNames<EventKind> {
  static constexpr auto names = std::to_array<std::pair<EventKind, std::string_view>>({
      {EventKind::kLost, "lost"},
      {EventKind::kRestarted, "restarted"},
      {EventKind::kRelocalized, "relocalized"},
      {EventKind::kLink, "loop link"},
      {EventKind::kWarning, "warning"},
  });
};

struct RunEvent {
  EventKind kind = EventKind::kLost;
  std::int64_t frame = 0;  // index in the input
  double seconds = 0;      // since the first frame [s]
  std::string text;
};

// In order of time. Consecutive lost frames are one event; a link is at the later of its keyframes.
[[nodiscard]] std::vector<RunEvent> events_of(const RunLog& log);

}  // namespace edvo
