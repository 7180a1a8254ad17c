// SPDX-License-Identifier: MIT
// What every page of a report is made of: head, style, scripts.
#pragma once

#include <string>

namespace edvo {

// title: plain text. body: HTML. route: JSON, what the script of the plots knows of frames.
[[nodiscard]] std::string html_page(const std::string& title, const std::string& body,
                                    const std::string& route);

}  // namespace edvo
