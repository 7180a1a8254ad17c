// SPDX-License-Identifier: MIT
// summary.json and frames.jsonl, read back.
#pragma once

#include "edvo/report/summary.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace edvo {

// source: named in messages. The configuration is not in summary.json. Throws Error(kInput) if the
// text is not what edvo writes, or of a later version.
[[nodiscard]] RunSummary parse_summary(std::string_view text, const std::string& source);

// Frames, and those that were skipped. Throws Error(kInput) "source:line: ...".
[[nodiscard]] RunLog parse_frames(std::string_view text, const std::string& source);

// The accepted ones of links.jsonl. Throws Error(kInput) "source:line: ...".
[[nodiscard]] std::vector<KeyframeLink> parse_links(std::string_view text,
                                                    const std::string& source);

}  // namespace edvo
