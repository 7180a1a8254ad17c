// SPDX-License-Identifier: MIT
// The report of a run: one page that needs nothing but a browser.
#pragma once

#include "edvo/report/summary.hpp"

#include <string>

namespace edvo {

// A self-contained page (style, plots and script inline, no network), below about 3 MB for any
// length of run. Text from outside is escaped.
[[nodiscard]] std::string to_html(const RunSummary& summary, const RunLog& log,
                                  const RunOutcome& outcome);

}  // namespace edvo
