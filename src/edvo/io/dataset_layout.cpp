// SPDX-License-Identifier: MIT
#include "edvo/io/dataset_layout.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <span>

namespace edvo {
namespace {

namespace fs = std::filesystem;

constexpr std::array kAssociationFiles = {"associations.txt", "associate.txt", "associated.txt",
                                          "association.txt", "assoc.txt"};
constexpr std::array kColourFolders = {"rgb",    "color",      "colour",       "image",
                                       "images", "rgb_images", "color_images", "colour_images"};
constexpr std::array kDepthFolders = {"depth", "depths", "depth_images"};

bool is_file(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_image(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

// The image files in a folder in the order of their names; hidden ones are left out.
std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> images;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (is_image(entry->path()) && entry->path().filename().string().front() != '.')
      images.push_back(entry->path());
  if (error)
    throw Error(ErrorCode::kInput, fmt::format("{}: {}", folder.string(), error.message()));
  std::ranges::sort(images);
  return images;
}

// As it is spelled, before one that differs by capital letters.
std::optional<fs::path> first_folder(const fs::path& root, std::span<const char* const> names) {
  std::error_code ignored;
  for (const char* const name : names)
    if (fs::is_directory(root / name, ignored)) return root / name;
  std::vector<fs::path> folders;
  for (fs::directory_iterator entry(root, ignored), end; !ignored && entry != end;
       entry.increment(ignored))
    folders.push_back(entry->path());
  std::ranges::sort(folders);
  for (const char* const name : names)
    for (const fs::path& folder : folders)
      if (lower_case(folder.filename().string()) == name && fs::is_directory(folder, ignored))
        return folder;
  return std::nullopt;
}

std::optional<Listing> list_stamped(const fs::path& root, const DatasetOptions& options) {
  const bool has_colour = is_file(root / "rgb.txt");
  const bool has_depth = is_file(root / "depth.txt");
  if (has_colour && has_depth) return read_tum_lists(root, options);
  for (const char* const name : kAssociationFiles)
    if (is_file(root / name)) return read_association_file(root / name, options);
  if (has_colour != has_depth)
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: {} is there but {} is not, nor an association file ({})", root.string(),
                    has_colour ? "rgb.txt" : "depth.txt", has_colour ? "depth.txt" : "rgb.txt",
                    fmt::join(kAssociationFiles, ", ")));
  return std::nullopt;
}

std::optional<Listing> list_two_folders(const fs::path& root, const DatasetOptions& options) {
  const std::optional<fs::path> colour_folder = first_folder(root, kColourFolders);
  const std::optional<fs::path> depth_folder = first_folder(root, kDepthFolders);
  if (!colour_folder || !depth_folder) return std::nullopt;
  const std::vector<fs::path> colour = images_in(*colour_folder);
  const std::vector<fs::path> depth = images_in(*depth_folder);
  if (colour.empty() || depth.empty())
    throw Error(ErrorCode::kInput,
                fmt::format("{}: no PNG or JPEG images in it",
                            (colour.empty() ? *colour_folder : *depth_folder).string()));
  std::optional<Listing> stamped = pair_stamped_files(colour, depth, options);
  Listing listing = stamped ? std::move(*stamped) : pair_numbered_files(colour, depth, options);
  listing.layout =
      fmt::format("{} images in {} and {}", stamped ? "stamped" : "numbered",
                  colour_folder->filename().string(), depth_folder->filename().string());
  if (std::error_code ignored; fs::is_directory(root / "intrinsic", ignored)) {
    listing.layout = "ScanNet";
    listing.shrink_colour = true;
  }
  return listing;
}

std::optional<Listing> list_one_folder(const fs::path& root, const DatasetOptions& options) {
  std::vector<fs::path> colour, depth, frames;
  for (const fs::path& file : images_in(root)) {
    const std::string name = lower_case(file.filename().string());
    const auto says = [&](const char* word) { return name.find(word) != std::string::npos; };
    if (says("depth")) {
      depth.push_back(file);
    } else if (says("color") || says("colour") || says("rgb")) {
      colour.push_back(file);
    } else if (says("frame")) {
      frames.push_back(file);
    }
  }
  const bool is_replica = colour.empty() && !frames.empty();  // frame000000.jpg, depth000000.png
  if (is_replica) colour = std::move(frames);
  if (colour.empty() || depth.empty()) return std::nullopt;
  Listing listing = pair_numbered_files(colour, depth, options);
  listing.layout = "numbered colour and depth images in one folder";
  if (is_replica) {
    constexpr double kReplicaScale = 6553.5;  // [units/m], cam_params.json of NICE-SLAM's Replica
    listing.layout = "Replica, frame* and depth* in one folder";
    listing.usual_depth_scale = kReplicaScale;
  }
  return listing;
}

}  // namespace

std::optional<Listing> list_frames(const fs::path& root, const DatasetOptions& options) {
  if (auto listing = list_stamped(root, options)) return listing;
  if (auto listing = list_two_folders(root, options)) return listing;
  return list_one_folder(root, options);
}

std::string describe_layouts() {
  return fmt::format(
      "rgb.txt and depth.txt (TUM), an association file ({}), folders of numbered or stamped "
      "images ({} with "
      "{}), or frame-000000.color.png with frame-000000.depth.png",
      fmt::join(kAssociationFiles, ", "), fmt::join(kColourFolders, ", "),
      fmt::join(kDepthFolders, ", "));
}

}  // namespace edvo
