// SPDX-License-Identifier: MIT
#include "edvo/io/curl_library.hpp"

#include "edvo/core/error.hpp"

#include <dlfcn.h>

namespace edvo {
namespace {

constexpr const char* kNames[] = {"libcurl.so.4", "libcurl-gnutls.so.4"};

template <typename Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  if (function == nullptr)
    throw Error(ErrorCode::kModel, std::string("libcurl has no ") + name + "; install libcurl4");
}

}  // namespace

CurlLibrary load_curl() {
  void* library = nullptr;  // stays loaded: libcurl has state of its own
  for (const char* name : kNames)
    if (library == nullptr) library = ::dlopen(name, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr)
    throw Error(ErrorCode::kModel,
                "downloads need libcurl, which is not installed (Debian: libcurl4); or fetch the "
                "file otherwise and give it with --from FILE");
  CurlLibrary curl;
  find(library, "curl_easy_init", curl.init);
  find(library, "curl_easy_cleanup", curl.cleanup);
  find(library, "curl_easy_setopt", curl.setopt);
  find(library, "curl_easy_getinfo", curl.getinfo);
  find(library, "curl_easy_perform", curl.perform);
  find(library, "curl_easy_strerror", curl.strerror);
  return curl;
}

}  // namespace edvo
