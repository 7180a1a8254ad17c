// SPDX-License-Identifier: MIT
#include "output_name.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/saved_map/map_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
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

void require_writable(std::string_view option, const std::string& file) {
  if (file.empty()) return;
  const fs::path place = followed(file);
  const fs::path folder = place.has_parent_path() ? place.parent_path() : ".";
  std::error_code ignored;
  const fs::file_status status = fs::status(place, ignored);
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::kOutput, fmt::format("{} {}: {}", option, file, why));
  };
  if (fs::is_directory(status)) refuse("is a folder; give the name of a file");
  if (!fs::is_directory(folder, ignored))
    refuse(fmt::format("there is no folder {}; make it, or choose another place", folder.string()));
  const bool is_special = fs::exists(status) && !fs::is_regular_file(status);
  if (::access((is_special ? place : folder).c_str(), W_OK) != 0)
    refuse(fmt::format("cannot be written: {}; choose a folder that you may write to",
                       std::strerror(errno)));
}

void require_new(std::string_view option, const std::string& file, bool force) {
  require_writable(option, file);
  if (force || !would_be_lost(file)) return;
  throw Error(ErrorCode::kOutput,
              fmt::format("{} {}: there is such a file; give another name, or replace it with "
                          "--force",
                          option, file));
}

void require_distinct(const std::vector<std::pair<std::string_view, std::string>>& outputs) {
  const auto place_of = [](const std::string& file) {
    return fs::absolute(followed(file)).lexically_normal();
  };
  for (std::size_t i = 0; i < outputs.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (!outputs[i].second.empty() && !outputs[j].second.empty() &&
          fs::status(outputs[i].second).type() != fs::file_type::character &&
          place_of(outputs[i].second) == place_of(outputs[j].second))
        throw Error(ErrorCode::kUsage,
                    fmt::format("{} and {} are both to be written to {}; give two names",
                                outputs[j].first, outputs[i].first, outputs[i].second));
}

void require_new_map(std::string_view option, const std::string& file, bool force) {
  require_map_or_nothing(file);
  require_new(option, file, force);
}

}  // namespace edvo::app
