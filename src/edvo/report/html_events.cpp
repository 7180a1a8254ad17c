// SPDX-License-Identifier: MIT
#include "edvo/report/html_events.hpp"

#include "edvo/report/events.hpp"
#include "edvo/report/markup.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace edvo {
namespace {

constexpr std::size_t kMostRows = 500;
constexpr std::string_view kWorstColor = "#444c56";

std::string_view color_of(EventKind kind) {
  switch (kind) {
    case EventKind::kLost:
      return "#d62728";
    case EventKind::kRestarted:
      return "#cc79a7";
    case EventKind::kRelocalized:
      return "#009e73";
    case EventKind::kLink:
      return "#0072b2";
    case EventKind::kWarning:
      break;
  }
  return "#e69f00";
}

bool is_countable(EventKind kind) {
  return kind == EventKind::kLink || kind == EventKind::kWarning;
}

std::string swatch(EventKind kind) {
  return fmt::format("<span class=\"swatch\" style=\"background:{}\"></span>{}", color_of(kind),
                     name_of(kind));
}

}  // namespace

std::string worst_frames_section(const RunLog& log) {
  if (log.worst.empty()) return "";
  std::string figures;
  for (std::size_t i = 0; i < log.worst.size(); ++i) {
    const WorstFrame& worst = log.worst[i];
    const std::string picture = worst.picture.empty()
                                    ? "<p class=\"soft\">no picture</p>"
                                    : fmt::format(
                                          "<img alt=\"colour image of frame {}\" data-frame=\"{}\" "
                                          "src=\"data:image/jpeg;base64,{}\">",
                                          worst.frame, worst.frame, worst.picture);
    figures += fmt::format(
        "<figure id=\"worst-{0}\">{1}<figcaption><b>{0}</b> frame {2}, {3:.2f} s: "
        "{4}</figcaption></figure>\n",
        i + 1, picture, worst.frame, worst.seconds, escape_markup(worst.reason));
  }
  return "<section class=\"card wide\"><h2>Worst frames</h2><p class=\"soft\">Numbered as in the "
         "plots over time. One frame of each moment, lost ones first.</p><div "
         "class=\"pictures\">\n" +
         figures + "</div></section>\n";
}

std::string events_card(const RunLog& log) {
  const std::vector<RunEvent> events = events_of(log);
  if (events.empty()) return "";
  std::string rows;
  std::map<EventKind, std::size_t> counts;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const RunEvent& event = events[i];
    ++counts[event.kind];
    if (i >= kMostRows) continue;
    rows += fmt::format(
        "<tr id=\"event-{}\"><td class=\"number\">{:.2f}</td><td class=\"number\">{}</td>"
        "<td>{}</td><td class=\"text\">{}</td></tr>\n",
        i + 1, event.seconds, event.frame, swatch(event.kind), escape_markup(event.text));
  }
  std::string legend;
  for (const auto& [kind, count] : counts)
    legend += fmt::format("{}{} {}{}", legend.empty() ? "" : " · ", count, name_of(kind),
                          count > 1 && is_countable(kind) ? "s" : "");
  if (events.size() > kMostRows) legend += fmt::format(" · the first {} are shown", kMostRows);
  return "<section class=\"card\"><h2>Events</h2><p class=\"soft\">" + legend +
         "</p><div class=\"scroll\"><table><thead><tr><th class=\"number\">time [s]</th>"
         "<th class=\"number\">frame</th><th>event</th><th>what</th></tr></thead><tbody>\n" +
         rows + "</tbody></table></div></section>\n";
}

std::vector<PlotEvent> plot_events_of(const RunLog& log) {
  std::vector<PlotEvent> marks;
  const std::vector<RunEvent> events = events_of(log);
  for (std::size_t i = 0; i < events.size(); ++i) {
    const RunEvent& event = events[i];
    marks.push_back(
        {.x = event.seconds,
         .text = fmt::format("{}, frame {}: {}", name_of(event.kind), event.frame, event.text),
         .color = std::string(color_of(event.kind)),
         .label = {},
         .link = i < kMostRows ? fmt::format("#event-{}", i + 1) : std::string()});
  }
  // Links are many, and must not hide what is rare.
  std::stable_partition(marks.begin(), marks.end(), [](const PlotEvent& mark) {
    return mark.color == color_of(EventKind::kLink);
  });
  for (std::size_t i = 0; i < log.worst.size(); ++i)
    marks.push_back({.x = log.worst[i].seconds,
                     .text = fmt::format("frame {}: {}", log.worst[i].frame, log.worst[i].reason),
                     .color = std::string(kWorstColor),
                     .label = fmt::format("{}", i + 1),
                     .link = fmt::format("#worst-{}", i + 1)});
  return marks;
}

}  // namespace edvo
