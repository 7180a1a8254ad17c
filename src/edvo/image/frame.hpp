// SPDX-License-Identifier: MIT
// One image as the tracker reads it: undistorted, grey, at several sizes.
#pragma once

#include "edvo/core/rolling_shutter.hpp"
#include "edvo/image/depth.hpp"

#include <vector>

namespace edvo {

constexpr int kMostLevels = 8;
// The paper's four, and two more for the first guess of a motion.
constexpr int kUsualLevels = 6;

struct Level {
  Camera camera;
  cv::Mat_<std::uint8_t> gray;  // H x W
};

struct Frame {
  Stamp stamp;
  std::vector<Level> levels;  // 0 = full size; level l is pyrDown of level l - 1
  Depth depth;                // of level 0
  cv::Mat bgr;                // the distorted original; undistorted by who needs colour
  RollingShutter shutter;

  // Mean squared gradient of the image at half size [grey levels^2]: motion blur lowers it.
  double sharpness = 0;
};

// levels: of the pyramid, the full image included; at most kMostLevels.
[[nodiscard]] Frame make_frame(const RgbdImage& image, const Undistortion& undistortion,
                               int levels = kUsualLevels);

}  // namespace edvo
