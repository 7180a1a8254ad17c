// SPDX-License-Identifier: MIT
#include "output_name.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/saved_map/map_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

std::string small_letters(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

void require_ending(std::string_view option, const std::string& file,
                    std::initializer_list<std::string_view> endings) {
  const std::string ending = small_letters(fs::path(file).extension().string());
  if (ending.empty() || std::ranges::find(endings, ending) != endings.end()) return;
  throw Error(ErrorCode::kUsage, fmt::format("{} {}: {} is not written here, only {}", option, file,
                                             ending, fmt::join(endings, ", ")));
}

void require_new(std::string_view option, const std::string& file, bool force) {
  if (force || !would_be_lost(file)) return;
  throw Error(ErrorCode::kOutput,
              fmt::format("{} {}: there is such a file; give another name, or replace it with "
                          "--force",
                          option, file));
}

void require_new_map(std::string_view option, const std::string& file, bool force) {
  require_map_or_nothing(file);
  require_new(option, file, force);
}

}  // namespace edvo::app
