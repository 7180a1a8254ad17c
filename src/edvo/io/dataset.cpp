// SPDX-License-Identifier: MIT
#include "edvo/io/dataset.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/archive.hpp"
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/camera_preset.hpp"
#include "edvo/io/dataset_layout.hpp"
#include "edvo/io/image_file.hpp"
#include "edvo/io/image_poses.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>

namespace edvo {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& place, std::string_view reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}: {}", place.string(), reason));
}

void check(const DatasetOptions& options) {
  const auto check_positive = [](const char* name, double value) {
    if (!std::isfinite(value) || value <= 0)
      throw Error(ErrorCode::kUsage, fmt::format("{} {}: must be a positive number", name, value));
  };
  check_positive("depth scale", options.depth_scale.value_or(1));
  check_positive("frame rate", options.assumed_rate);
  check_positive("largest gap", options.largest_gap);
}

// The folder's name also of "." and "a/b/", and the archive's without its endings.
std::string name_of_source(const fs::path& source, bool is_archive) {
  fs::path whole = fs::absolute(source).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  std::string name = whole.filename().string();
  if (!is_archive) return name.empty() ? "sequence" : name;
  for (const std::string_view ending :
       {".gz", ".bz2", ".xz", ".zst", ".tar", ".tgz", ".tbz2", ".txz", ".zip"})
    if (name.size() > ending.size() && name.ends_with(ending))
      name.resize(name.size() - ending.size());
  return name;
}

// The folder's only visible subfolder, if that is so: archives often wrap what they hold.
std::optional<fs::path> only_subfolder(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    std::error_code ignored;
    if (name.front() != '.' && name != "__MACOSX" && entry->is_directory(ignored))
      folders.push_back(entry->path());
  }
  if (error) fail(folder, error.message());
  return folders.size() == 1 ? std::optional(folders.front()) : std::nullopt;
}

struct Found {
  fs::path root;
  Listing listing;
};

Found find_sequence(const fs::path& folder, const DatasetOptions& options) {
  constexpr int kDeepest = 3;
  std::optional<fs::path> place = folder;
  for (int depth = 0; place && depth <= kDeepest; ++depth) {
    if (auto listing = list_frames(*place, options)) return {*place, std::move(*listing)};
    place = only_subfolder(*place);
  }
  std::error_code ignored;
  fail(folder,
       fmt::format("{}no RGB-D sequence here; looked for {}",
                   fs::is_empty(folder, ignored) ? "empty folder, " : "", describe_layouts()));
}

Found find_unpacked_sequence(const fs::path& folder, const DatasetOptions& options) {
  try {
    return find_sequence(folder, options);
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);  // what cannot be used is not kept
    throw;
  }
}

std::optional<fs::path> find_ground_truth(const fs::path& root) {
  std::error_code ignored;
  for (const char* const name : {"groundtruth.txt", "ground_truth.txt", "groundtruth.tum"})
    if (fs::is_regular_file(root / name, ignored)) return root / name;
  std::vector<fs::path> freiburg;  // as ICL-NUIM names it: livingRoom0.gt.freiburg
  for (fs::directory_iterator entry(root, ignored), end; !ignored && entry != end;
       entry.increment(ignored))
    if (entry->path().string().ends_with(".gt.freiburg")) freiburg.push_back(entry->path());
  return freiburg.size() == 1 ? std::optional(freiburg.front()) : std::nullopt;
}

bool lies_in(const fs::path& root, const fs::path& file) {
  const fs::path relative = file.lexically_normal().lexically_relative(root.lexically_normal());
  return !relative.empty() && *relative.begin() != "..";
}

// Lists may name files anywhere; an archive's may not, who made it does not know this machine.
void check_places(Dataset& dataset, bool is_archive) {
  std::size_t outside = 0;
  const fs::path* example = nullptr;
  for (const FrameEntry& frame : dataset.frames)
    for (const fs::path* const file : {&frame.colour, &frame.depth})
      if (!lies_in(dataset.root, *file) && outside++ == 0) example = file;
  if (outside == 0) return;
  const std::string what =
      fmt::format("{} images lie outside the folder, the first is {}", outside, example->string());
  if (is_archive) fail(dataset.source, what);
  dataset.warnings.push_back(fmt::format("{}: {}", dataset.root.string(), what));
}

void check_existence(Dataset& dataset) {
  std::size_t missing = 0;
  const fs::path* example = nullptr;
  for (const FrameEntry& frame : dataset.frames) {
    std::error_code ignored;
    const bool has_colour = fs::exists(frame.colour, ignored);
    if (has_colour && fs::exists(frame.depth, ignored)) continue;
    if (missing++ == 0) example = has_colour ? &frame.depth : &frame.colour;
  }
  if (missing == 0) return;
  const std::string what = fmt::format("{} of {} frames lack an image file, the first is {}",
                                       missing, dataset.frames.size(), example->string());
  if (missing == dataset.frames.size()) fail(dataset.root, what);
  dataset.warnings.push_back(
      fmt::format("{}: {}; they will be skipped", dataset.root.string(), what));
}

void add_poses_beside_images(Dataset& dataset) {
  std::optional<ImagePoses> poses;
  try {
    poses = read_image_poses(dataset.root, dataset.frames);
  } catch (const Error& error) {  // the images can be tracked all the same
    dataset.warnings.push_back(std::string("no ground truth: ") + error.what());
  }
  if (!poses) return;
  dataset.notes.push_back(fmt::format("ground truth: {}", poses->source));
  dataset.warnings.insert(dataset.warnings.end(), poses->warnings.begin(), poses->warnings.end());
  dataset.poses = std::move(poses->trajectory);
  dataset.poses_source = std::move(poses->source);
}

DepthScale choose_depth_scale(const Dataset& dataset, const Listing& listing,
                              const DatasetOptions& options) {
  if (options.depth_scale) return {*options.depth_scale, "as given"};
  const std::optional<fs::path> camera_file =
      options.camera_file ? options.camera_file : camera_file_in(dataset.root);
  if (const auto stated = camera_file ? stated_depth_scale(*camera_file) : std::nullopt)
    return {stated->units_per_metre,
            fmt::format("{} in {}", stated->key, camera_file->filename().string())};
  // --camera may give another calibration of the same camera; its depth stays in the same units.
  const auto own_file = options.camera_file ? camera_file_in(dataset.root) : std::nullopt;
  if (const auto stated = own_file ? stated_depth_scale(*own_file) : std::nullopt)
    return {stated->units_per_metre,
            fmt::format("{} in the folder's {}, as {} states none", stated->key,
                        own_file->filename().string(), camera_file->filename().string())};
  if (const auto preset = camera_preset(dataset))
    return {preset->depth_scale, fmt::format("{}, {}", preset->name, preset->recognised)};
  return {listing.usual_depth_scale, fmt::format("assumed, usual for {}", listing.layout), true};
}

// A frame's images as stored, whatever their sizes.
struct StoredFrame {
  cv::Mat_<cv::Vec3b> bgr;
  cv::Mat_<std::uint16_t> depth;
};

constexpr int kSmallestSide = 8;  // [px], of what is tracked

StoredFrame read_stored(const FrameEntry& frame, bool shrink_colour) {
  StoredFrame stored{.bgr = read_colour(frame.colour), .depth = read_depth_raw(frame.depth)};
  if (shrink_colour && stored.bgr.size() != stored.depth.size() && stored.depth.total() > 0)
    cv::resize(stored.bgr, stored.bgr, stored.depth.size(), 0, 0, cv::INTER_AREA);
  return stored;
}

void check_registration(const FrameEntry& frame, const StoredFrame& stored) {
  if (stored.depth.size() == stored.bgr.size()) return;
  fail(frame.depth,
       fmt::format("depth of {} x {} px, but colour {} has {} x {} px; depth must be "
                   "registered to colour, pixel by pixel (edvo's Python package does that: "
                   "--depth-camera FILE)",
                   stored.depth.cols, stored.depth.rows, frame.colour.string(), stored.bgr.cols,
                   stored.bgr.rows));
}

void check_size(const fs::path& file, cv::Size size, cv::Size expected) {
  if (size != expected)
    fail(file, fmt::format("{} x {} px, but the sequence has {} x {} px", size.width, size.height,
                           expected.width, expected.height));
}

// Files may be damaged, but one frame must be whole; the first such speaks for the sequence.
StoredFrame first_readable_frame(const Dataset& dataset) {
  std::optional<Error> first_error;
  for (const FrameEntry& frame : dataset.frames) {
    StoredFrame stored;
    try {
      stored = read_stored(frame, dataset.shrink_colour);
    } catch (const Error& error) {
      if (!first_error) first_error = error;
      continue;
    }
    if (dataset.is_depth_registered) check_registration(frame, stored);
    return stored;
  }
  fail(dataset.root, fmt::format("none of the {} frames can be read; the first: {}",
                                 dataset.frames.size(), first_error->what()));
}

// Depth images spread over the sequence; those that cannot be read or are empty have no say.
DepthValues sample_depth(const Dataset& dataset) {
  constexpr std::size_t kSamples = 6, kTries = 24, kStride = 5;  // no common divisor
  DepthValues values;
  const std::size_t count = dataset.frames.size(), tries = std::min(count, kTries);
  std::size_t with_depth = 0;
  for (std::size_t i = 0; i < kTries && with_depth < kSamples; ++i) {
    const std::size_t place = i * kStride % kTries;  // far apart first, in the end all of them
    if (place >= tries) continue;
    try {
      const cv::Mat_<std::uint16_t> raw =
          read_depth_raw(dataset.frames[place * count / tries].depth);
      add_image(values, raw);
      if (cv::countNonZero(raw) > 0) ++with_depth;
    } catch (const Error&) {
      continue;  // is skipped when its turn comes
    }
  }
  return values;
}

}  // namespace

Dataset open_dataset(const fs::path& source, const DatasetOptions& options) {
  check(options);
  std::error_code error;
  const fs::file_status status = fs::status(source, error);
  if (status.type() == fs::file_type::not_found) fail(source, "no such folder or archive");
  if (error) fail(source, error.message());
  const bool is_archive = !fs::is_directory(status);
  if (is_archive && !fs::is_regular_file(status)) fail(source, "neither a folder nor an archive");

  Dataset dataset;
  dataset.name = name_of_source(source, is_archive);
  dataset.source = source;
  fs::path folder = source;
  if (is_archive) {
    folder = unpack_archive(source, options.cache, options.on_unpack);
    dataset.notes.push_back(fmt::format("unpacked in {}", folder.string()));
  }
  auto [root, listing] =
      is_archive ? find_unpacked_sequence(folder, options) : find_sequence(folder, options);
  dataset.root = std::move(root);
  dataset.layout = listing.layout;
  dataset.frames = std::move(listing.frames);
  dataset.colour_count = listing.colour_count;
  dataset.depth_count = listing.depth_count;
  dataset.shrink_colour = listing.shrink_colour;
  dataset.is_depth_registered = options.is_depth_registered;
  dataset.ground_truth = find_ground_truth(dataset.root);
  dataset.notes.insert(dataset.notes.end(), listing.notes.begin(), listing.notes.end());
  dataset.warnings = std::move(listing.warnings);
  if (!dataset.ground_truth) add_poses_beside_images(dataset);
  check_places(dataset, is_archive);
  check_existence(dataset);

  dataset.depth_scale = choose_depth_scale(dataset, listing, options);
  dataset.notes.push_back(fmt::format("{} depth units per metre ({})",
                                      dataset.depth_scale.units_per_metre,
                                      dataset.depth_scale.source));
  const StoredFrame first = first_readable_frame(dataset);
  dataset.image_size = first.bgr.size();
  dataset.depth_size = first.depth.size();
  if (std::min(dataset.image_size.width, dataset.image_size.height) < kSmallestSide)
    fail(dataset.root,
         fmt::format("images of {} x {} px are too small; sides start at {} px",
                     dataset.image_size.width, dataset.image_size.height, kSmallestSide));
  const DepthFindings depth = check_depth(sample_depth(dataset), dataset.depth_scale);
  dataset.notes.insert(dataset.notes.end(), depth.notes.begin(), depth.notes.end());
  dataset.warnings.insert(dataset.warnings.end(), depth.warnings.begin(), depth.warnings.end());
  return dataset;
}

RgbdImage read_frame(const Dataset& dataset, std::size_t index) {
  const FrameEntry& frame = dataset.frames.at(index);
  const StoredFrame stored = read_stored(frame, dataset.shrink_colour);
  if (dataset.is_depth_registered) check_registration(frame, stored);
  check_size(frame.colour, stored.bgr.size(), dataset.image_size);
  check_size(frame.depth, stored.depth.size(), dataset.depth_size);
  return {.stamp = frame.stamp,
          .bgr = stored.bgr,
          .depth = depth_to_metres(stored.depth, dataset.depth_scale.units_per_metre)};
}

}  // namespace edvo
