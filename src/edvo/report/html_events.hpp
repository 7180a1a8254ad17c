// SPDX-License-Identifier: MIT
// The parts of the report page that tell what happened: the worst frames and the events.
#pragma once

#include "edvo/report/plot.hpp"
#include "edvo/report/summary.hpp"

#include <string>
#include <vector>

namespace edvo {

// Pictures of the worst frames, each with its reason; empty if none was kept.
[[nodiscard]] std::string worst_frames_section(const RunLog& log);

// A table of all events; empty if nothing happened.
[[nodiscard]] std::string events_card(const RunLog& log);

// Events and worst frames as marks of plots over time, linked to the two above.
[[nodiscard]] std::vector<PlotEvent> plot_events_of(const RunLog& log);

}  // namespace edvo
