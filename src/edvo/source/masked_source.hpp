// SPDX-License-Identifier: MIT
// A source without the part of its images that shows what moves with the camera: a robot's arm, the
// rim of a window, a caption.
#pragma once

#include "edvo/source/rgbd_source.hpp"

#include <filesystem>
#include <memory>

namespace edvo {

// Visible where the image is at least half bright: H x W, 255 = visible, 0 = hidden. Any PNG or
// JPEG. Throws Error(kInput) if it cannot be read, is not of this size or hides everything.
[[nodiscard]] cv::Mat_<std::uint8_t> read_mask(const std::filesystem::path& file, cv::Size size);

// What is hidden has no depth, so nothing there is tracked or mapped.
class MaskedSource final : public RgbdSource {
 public:
  // mask: as read_mask gives it, of the size of the source's images as they come (not undistorted);
  // throws Error(kInput) if it is not. name: for the notes.
  MaskedSource(std::unique_ptr<RgbdSource> source, const cv::Mat_<std::uint8_t>& mask,
               const std::string& name);

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] std::optional<PendingFrame> next() override;
  void stop() override { source_->stop(); }

 private:
  std::unique_ptr<RgbdSource> source_;
  SourceInfo info_;
  cv::Mat_<std::uint8_t> hidden_;  // 255 = hidden
};

}  // namespace edvo
