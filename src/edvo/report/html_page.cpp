// SPDX-License-Identifier: MIT
#include "edvo/report/html_page.hpp"

#include "edvo/report/html_assets.hpp"
#include "edvo/report/markup.hpp"

#include <fmt/core.h>

namespace edvo {

std::string html_page(const std::string& title, const std::string& body, const std::string& route) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{} · edvo</title>\n<style>{}</style></head>\n<body><main>\n{}"
      "</main><div id=\"tip\"></div>\n<script type=\"application/json\" id=\"route\">{}</script>\n"
      "<script>{}</script><script>{}</script></body></html>\n",
      escape_markup(title), kReportStyle, body, route, kReportScript, kSpaceScript);
}

}  // namespace edvo
