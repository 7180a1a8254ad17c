// SPDX-License-Identifier: MIT
#include "edvo/report/plot_events.hpp"

#include "edvo/report/markup.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace edvo {
namespace {

constexpr double kApart = 4;  // marks closer than this are one [px]
constexpr std::size_t kMostTexts = 5;

struct Mark {
  double x = 0;  // [px]
  const PlotEvent* first = nullptr;
  std::string text;
  std::size_t events = 1;
};

void join(Mark& mark, const PlotEvent& event) {
  ++mark.events;
  if (mark.events <= kMostTexts) mark.text += "\n" + event.text;
  if (mark.events == kMostTexts + 1) mark.text += "\n...";
}

std::vector<Mark> marks_of(const std::vector<PlotEvent>& events, const PlotArea& area) {
  std::vector<Mark> marks;
  const double range = area.x.high - area.x.low;
  for (const PlotEvent& event : events) {
    if (range <= 0 || event.x < area.x.low || event.x > area.x.high) continue;
    const double x = area.left + (event.x - area.x.low) / range * area.width;
    const auto same = std::ranges::find_if(marks, [&](const Mark& mark) {
      return event.label.empty() && mark.first->label.empty() && mark.first->color == event.color &&
             std::abs(mark.x - x) < kApart;
    });
    if (same != marks.end()) {
      join(*same, event);
    } else {
      marks.push_back({.x = x, .first = &event, .text = event.text});
    }
  }
  return marks;
}

std::string to_svg(const Mark& mark, const PlotArea& area) {
  const PlotEvent& event = *mark.first;
  const std::string color = escape_markup(event.color);
  std::string svg = fmt::format(
      "<path d=\"M{0:.1f} {1:.1f}v{2:.1f}\" stroke=\"{3}\" stroke-opacity=\".45\" "
      "stroke-dasharray=\"2 3\" fill=\"none\"/>",
      mark.x, area.top, area.height, color);
  if (event.label.empty()) {
    svg += fmt::format("<path d=\"M{:.1f} {:.1f}h10l-5 9z\" fill=\"{}\"/>", mark.x - 5, area.top,
                       color);
  } else {
    svg += fmt::format(
        "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"8\" fill=\"{2}\"/><text x=\"{0:.1f}\" "
        "y=\"{3:.1f}\" text-anchor=\"middle\" font-size=\"11\" font-weight=\"700\" "
        "style=\"fill:#fff\">{4}</text>",
        mark.x, area.top + 19, color, area.top + 23, escape_markup(event.label));
  }
  svg += "<title>" + escape_markup(mark.text) + "</title>";
  if (event.link.empty()) return "<g class=\"event\">" + svg + "</g>\n";
  return fmt::format("<a class=\"event\" href=\"{}\">{}</a>\n", escape_markup(event.link), svg);
}

}  // namespace

std::string event_marks(const std::vector<PlotEvent>& events, const PlotArea& area) {
  std::string svg;
  for (const Mark& mark : marks_of(events, area)) svg += to_svg(mark, area);
  return svg;
}

}  // namespace edvo
