// SPDX-License-Identifier: MIT
#include "edvo/source/folder_source.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/camera_choice.hpp"
#include "edvo/io/trajectory_file.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace edvo {
namespace {

// A ground truth that cannot be read is no reason not to track.
std::optional<GroundTruth> read_ground_truth(const Dataset& dataset,
                                             std::vector<std::string>& warnings) {
  if (!dataset.poses.empty()) return GroundTruth{dataset.poses_source, dataset.poses};
  if (!dataset.ground_truth) return std::nullopt;
  try {
    TrajectoryFile file = read_trajectory(*dataset.ground_truth);
    warnings.insert(warnings.end(), file.warnings.begin(), file.warnings.end());
    return GroundTruth{dataset.ground_truth->string(), std::move(file.trajectory)};
  } catch (const Error& error) {
    warnings.push_back(fmt::format("no evaluation: {}", error.what()));
    return std::nullopt;
  }
}

SourceInfo describe(const Dataset& dataset, const ChosenCamera& camera) {
  SourceInfo info{
      .name = dataset.name,
      .origin = fmt::format("{} ({})", dataset.source.string(), dataset.layout),
      .camera = camera.camera,
      .camera_origin = camera.source,
      .depth_scale = dataset.depth_scale.units_per_metre,
      .depth_origin = fmt::format("{} units per metre ({})", dataset.depth_scale.units_per_metre,
                                  dataset.depth_scale.source),
      .is_depth_assumed = dataset.depth_scale.is_assumed,
      .notes = dataset.notes,
      .warnings = dataset.warnings};
  info.warnings.insert(info.warnings.end(), camera.warnings.begin(), camera.warnings.end());
  info.ground_truth = read_ground_truth(dataset, info.warnings);
  return info;
}

}  // namespace

FolderSource::FolderSource(const std::filesystem::path& sequence, const FolderOptions& options)
    : dataset_(open_dataset(sequence, {.depth_scale = options.depth_scale,
                                       .camera_file = options.camera_file,
                                       .is_depth_registered = options.is_depth_registered,
                                       .cache = options.cache,
                                       .on_unpack = options.on_unpack})) {
  info_ =
      describe(dataset_,
               choose_camera(dataset_, {.file = options.camera_file, .size = options.camera_size}));
  begin_ = static_cast<std::size_t>(options.first);
  end_ = dataset_.frames.size();
  if (options.first < 0 || begin_ >= end_)
    throw Error(ErrorCode::kUsage, fmt::format("frame {} to begin with: {} has only {} frames",
                                               options.first, dataset_.source.string(), end_));
  if (options.max_frames > 0)
    end_ = std::min(end_, begin_ + static_cast<std::size_t>(options.max_frames));
  info_.frames = static_cast<std::int64_t>(end_ - begin_);
  next_ = begin_;
}

std::optional<PendingFrame> FolderSource::next() {
  if (next_ >= end_) return std::nullopt;
  const std::size_t i = next_++;
  return PendingFrame{.index = static_cast<std::int64_t>(i),
                      .stamp = dataset_.frames[i].stamp,
                      .load = [this, i] { return read_frame(dataset_, i); }};
}

}  // namespace edvo
