// SPDX-License-Identifier: MIT
#include "edvo/io/camera_preset.hpp"

#include <fmt/core.h>
#include <array>
#include <regex>

namespace edvo {
namespace {

constexpr int kWidth = 640, kHeight = 480;  // [px] of every preset

struct KnownCamera {
  const char* name;
  const char* pattern;  // in a name, any case
  DistortedCamera camera;
};

// TUM's colour cameras as calibrated by its authors. ICL-NUIM is rendered in a world whose y axis
// points up: with fy < 0 the estimate comes out in that world, as the ground truth that is
// published with it; with fy > 0 it would come out mirrored, and no rigid motion aligns the two.
constexpr auto kKnownCameras = std::to_array<KnownCamera>({
    {"TUM freiburg1",
     "freiburg1|(^|[^a-z0-9])fr1(?![0-9a-z])",
     {.pinhole = {517.306408, 516.469215, 318.643040, 255.313989, kWidth, kHeight},
      .distortion = {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}}},
    {"TUM freiburg2",
     "freiburg2|(^|[^a-z0-9])fr2(?![0-9a-z])",
     {.pinhole = {520.908620, 521.007327, 325.141442, 249.701764, kWidth, kHeight},
      .distortion = {0.231222, -0.784899, -0.003257, -0.000105, 0.917205}}},
    {"TUM freiburg3",
     "freiburg3|(^|[^a-z0-9])fr3(?![0-9a-z])",
     {.pinhole = {535.4, 539.2, 320.1, 247.6, kWidth, kHeight}}},
    {"Bonn RGB-D Dynamic",
     "rgbd_bonn",
     {.pinhole = {542.822841, 542.576870, 315.593520, 237.756098, kWidth, kHeight},
      .distortion = {0.039903, -0.099343, -0.000730, -0.000144, 0}}},
    {"ICL-NUIM",
     "(^|[^a-z])icl([^a-z]|$)|traj[0-3]n?_frei|"
     "(living[-_ ]?room|office|(^|[^a-z])lr|(^|[^a-z])of)[-_ ]?(traj|kt)[-_ ]?[0-3]",
     {.pinhole = {481.2, -480, 319.5, 239.5, kWidth, kHeight}}},
});

CameraPreset preset_of(const KnownCamera& known, std::string recognised) {
  return {.name = known.name, .recognised = std::move(recognised), .camera = known.camera};
}

}  // namespace

std::optional<CameraPreset> camera_preset(std::string_view name) {
  for (const KnownCamera& known : kKnownCameras) {
    const std::regex pattern(known.pattern, std::regex::ECMAScript | std::regex::icase);
    std::match_results<std::string_view::const_iterator> match;
    if (std::regex_search(name.begin(), name.end(), match, pattern))
      return preset_of(known, fmt::format("'{}' in the name {}", match.str(), name));
  }
  return std::nullopt;
}

std::optional<CameraPreset> camera_preset(const Dataset& dataset) {
  if (auto preset = camera_preset(dataset.name)) return preset;
  std::error_code ignored;  // the real name of "." or of a link
  const auto root = std::filesystem::canonical(dataset.root, ignored);
  if (auto preset = camera_preset(root.filename().string())) return preset;
  // ICL-NUIM's archives unpack without a folder of their own, into whatever the user called it.
  if (dataset.ground_truth && dataset.ground_truth->string().ends_with(".gt.freiburg"))
    return preset_of(kKnownCameras.back(),
                     fmt::format("by its file {}", dataset.ground_truth->filename().string()));
  return std::nullopt;
}

}  // namespace edvo
