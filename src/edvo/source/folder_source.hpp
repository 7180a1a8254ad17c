// SPDX-License-Identifier: MIT
// A recorded sequence in a folder or an archive.
#pragma once

#include "edvo/io/dataset.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

namespace edvo {

struct FolderOptions {
  std::optional<std::filesystem::path> camera_file = {};  // none = found with the sequence
  cv::Size camera_size = {};  // [px] of the calibration images, empty = that of the images
  std::optional<double> depth_scale = {};           // [units/m], none = found with the sequence
  bool is_depth_registered = true;                  // see DatasetOptions
  std::int64_t first = 0;                           // frame to begin with
  std::int64_t max_frames = 0;                      // 0 = all
  std::filesystem::path cache = {};                 // where archives are unpacked
  std::function<void(double)> on_unpack = nullptr;  // see DatasetOptions
};

class FolderSource final : public RgbdSource {
 public:
  // Throws what open_dataset() and choose_camera() throw, and Error(kUsage) if there is no frame
  // options.first. A ground truth that cannot be read is a warning.
  explicit FolderSource(const std::filesystem::path& sequence, const FolderOptions& options = {});

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] std::optional<PendingFrame> next() override;

  // Begins again with the first frame.
  void rewind() { next_ = begin_; }

  [[nodiscard]] const Dataset& dataset() const { return dataset_; }

 private:
  Dataset dataset_;
  SourceInfo info_;
  std::size_t begin_ = 0, end_ = 0, next_ = 0;  // [begin, end) of the data set's frames
};

}  // namespace edvo
