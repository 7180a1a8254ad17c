// SPDX-License-Identifier: MIT
// The style and the script of the report page, as text.
#pragma once

#include <string_view>

namespace edvo {

extern const std::string_view kReportStyle;   // CSS
extern const std::string_view kReportScript;  // JavaScript; the page is complete without it
extern const std::string_view kSpaceScript;   // JavaScript that lets the card of html_space turn

}  // namespace edvo
