// SPDX-License-Identifier: MIT
#include "edvo/frame/frame.hpp"

#include <opencv2/imgproc.hpp>

namespace edvo {

Frame make_frame(const RgbdImage& image, const Undistortion& undistortion,
                 const FrameOptions& options) {
  cv::Mat gray;
  cv::cvtColor(image.bgr, gray, cv::COLOR_BGR2GRAY);
  Frame frame{.stamp = image.stamp,
              .levels = {{undistortion.camera, undistort_colour(undistortion, gray)}},
              .depth = undistort_depth(undistortion, image.depth),
              .bgr = image.bgr};
  for (int l = 1; l < options.levels; ++l) {
    const Level& finer = frame.levels.back();
    Level level{.camera = half_size(finer.camera), .gray = {}};
    cv::pyrDown(finer.gray, level.gray);
    frame.levels.push_back(level);
  }
  return frame;
}

}  // namespace edvo
