// SPDX-License-Identifier: MIT
#include "model_choice.hpp"

#include "cache_folder.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/model_cache.hpp"

#include <fmt/core.h>

namespace edvo::app {

namespace fs = std::filesystem;

fs::path models_folder() {
  const fs::path cache = cache_folder();
  if (cache.empty())
    throw Error(ErrorCode::kModel,
                "no folder for models: neither XDG_CACHE_HOME nor HOME is set to a full path");
  return cache / "models";
}

std::string how_to_get(const std::string& known) {
  return fmt::format(
      "get it with `edvo pull {0}` (Python package), or download {1} and run: edvo models import "
      "FILE",
      known, find_known_model(known)->addresses.front());
}

std::string model_file(const std::string& file_or_name) {
  std::error_code ignored;
  if (file_or_name.empty() || fs::is_regular_file(file_or_name, ignored)) return file_or_name;
  const fs::path cache = cache_folder();
  if (!cache.empty())
    if (const auto description = find_cached_model(cache / "models", file_or_name))
      return description->string();
  if (find_known_model(file_or_name) != nullptr)
    throw Error(ErrorCode::kModel,
                fmt::format("model {} is not there; {}", file_or_name, how_to_get(file_or_name)));
  return file_or_name;
}

}  // namespace edvo::app
