// SPDX-License-Identifier: MIT
#include "python_package.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

struct Extra {
  std::string_view name, extra;
};

constexpr auto kVerbsAndOptions = std::to_array<Extra>({{"doctor", ""},
                                                        {"export", ""},
                                                        {"pull", ""},
                                                        {"view", "view"},
                                                        {"--view", "view"},
                                                        {"--record", "view"},
                                                        {"--mcap", "ros"},
                                                        {"--colour-topic", "ros"},
                                                        {"--depth-topic", "ros"},
                                                        {"--depth-camera", ""},
                                                        {"--colour-from-depth", ""},
                                                        {"--no-doctor", ""}});

constexpr auto kEndings = std::to_array<Extra>(
    {{".bag", "ros"}, {".db3", "ros"}, {".mcap", "ros"}, {".mkv", "video"}, {".r3d", "record3d"}});

constexpr auto kCameras = std::to_array<Extra>(
    {{"camera:realsense", "realsense"}, {"camera:oak", "oak"}, {"camera:openni", "openni"}});

std::string needs_package(const std::string& what, std::string_view extra) {
  const std::string package = extra.empty() ? "." : fmt::format("'.[{}]'", extra);
  return fmt::format("{} needs the Python package: in a checkout of edvo, pip install {}", what,
                     package);
}

bool is_file(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

// As python/edvo/sources tells them apart.
std::optional<std::string_view> extra_for(const fs::path& sequence) {
  if (is_file(sequence))
    for (const auto& [ending, extra] : kEndings)
      if (sequence.extension() == ending) return extra;
  for (const auto& [name, extra] : kCameras)
    if (sequence.string().starts_with(name)) return extra;
  if (sequence.string().starts_with("camera:")) return "";
  if (is_file(sequence / "rgb.mp4") && is_file(sequence / "camera_matrix.csv")) return "video";
  std::error_code ignored;
  if (is_file(sequence / "metadata") && fs::is_directory(sequence / "rgbd", ignored))
    return "record3d";
  if (is_file(sequence / "metadata.yaml")) return "ros";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> said_of_package(const std::string& verb_or_option) {
  const auto found = std::ranges::find(kVerbsAndOptions, verb_or_option, &Extra::name);
  if (found == kVerbsAndOptions.end()) return std::nullopt;
  const bool is_option = verb_or_option.starts_with('-');
  return needs_package(is_option ? verb_or_option : "edvo " + verb_or_option, found->extra);
}

void refuse_what_package_reads(const fs::path& sequence) {
  if (const auto extra = extra_for(sequence))
    throw Error(ErrorCode::kUsage,
                needs_package(fmt::format("{}: reading it", sequence.string()), *extra));
}

}  // namespace edvo::app
