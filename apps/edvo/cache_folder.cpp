// SPDX-License-Identifier: MIT
#include "cache_folder.hpp"

#include <cstdlib>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

// Relative paths are to be ignored, says the XDG specification.
fs::path absolute_path_in(const char* variable) {
  const char* const value = std::getenv(variable);
  const fs::path path(value == nullptr ? "" : value);
  return path.is_absolute() ? path : fs::path();
}

}  // namespace

fs::path cache_folder() {
  if (const fs::path cache = absolute_path_in("XDG_CACHE_HOME"); !cache.empty())
    return cache / "edvo";
  if (const fs::path home = absolute_path_in("HOME"); !home.empty())
    return home / ".cache" / "edvo";
  return {};
}

}  // namespace edvo::app
