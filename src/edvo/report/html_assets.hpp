// SPDX-License-Identifier: MIT
// The style and the script of the report page, as text.
#pragma once

#include <string_view>

namespace edvo {

extern const std::string_view kReportStyle;   // CSS
extern const std::string_view kReportScript;  // JavaScript; the page is complete without it

}  // namespace edvo
