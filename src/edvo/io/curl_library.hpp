// SPDX-License-Identifier: MIT
// libcurl, loaded when it is needed.
#pragma once

#include <curl/curl.h>

namespace edvo {

// Linked as usual, libcurl and the 27 libraries that it brings would add 17 ms, half as much again,
// to each start of the program; one verb in a hundred calls needs them.
struct CurlLibrary {
  decltype(&curl_easy_init) init = nullptr;
  decltype(&curl_easy_cleanup) cleanup = nullptr;
  decltype(&curl_easy_setopt) setopt = nullptr;
  decltype(&curl_easy_getinfo) getinfo = nullptr;
  decltype(&curl_easy_perform) perform = nullptr;
  decltype(&curl_easy_strerror) strerror = nullptr;
};

// Throws Error(kModel) if it is not installed.
[[nodiscard]] CurlLibrary load_curl();

}  // namespace edvo
