// SPDX-License-Identifier: MIT
// One image as the tracker reads it: undistorted, grey, at several sizes.
#pragma once

#include "edvo/core/fields.hpp"
#include "edvo/image/depth.hpp"

#include <concepts>
#include <vector>

namespace edvo {

constexpr int kMostLevels = 8;

struct FrameOptions {
  int levels = 6;
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, FrameOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("levels", self.levels, Range{1, kMostLevels},
        "pyramid levels, the full image included; the paper's four and coarser ones");
}

struct Level {
  Camera camera;
  cv::Mat_<std::uint8_t> gray;  // H x W
};

struct Frame {
  Stamp stamp;
  std::vector<Level> levels;  // 0 = full size; level l is pyrDown of level l - 1
  Depth depth;                // of level 0
  cv::Mat bgr;                // the distorted original; undistorted by who needs colour
  // Mean squared gradient of the image at half size [grey levels^2]: motion blur lowers it.
  double sharpness = 0;
  // Only where asked for: of every level, distance to the nearest edge, truncated [px of the
  // level].
  std::vector<cv::Mat_<float>> edge_distance{};
};

[[nodiscard]] Frame make_frame(const RgbdImage& image, const Undistortion& undistortion,
                               const FrameOptions& options);

}  // namespace edvo
