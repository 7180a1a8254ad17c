// SPDX-License-Identifier: MIT
#include "edvo/image/frame.hpp"

#include "edvo/simd/dispatch.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Of one row and the one below it, by forward differences; fits into 32 bits up to 16,000 columns.
EDVO_CLONES std::uint32_t squared_gradients(const std::uint8_t* row, const std::uint8_t* below,
                                            int count) {
  std::uint32_t sum = 0;
  for (int x = 0; x + 1 < count; ++x) {
    const int dx = row[x + 1] - row[x], dy = below[x] - row[x];
    sum += static_cast<std::uint32_t>(dx * dx + dy * dy);
  }
  return sum;
}

double mean_squared_gradient(const cv::Mat_<std::uint8_t>& gray) {
  double sum = 0;
  for (int y = 0; y + 1 < gray.rows; ++y)
    sum += static_cast<double>(squared_gradients(gray[y], gray[y + 1], gray.cols));
  return sum / static_cast<double>(gray.total());
}

}  // namespace

Frame make_frame(const RgbdImage& image, const Undistortion& undistortion, int level_count) {
  cv::Mat gray;
  cv::cvtColor(image.bgr, gray, cv::COLOR_BGR2GRAY);
  Frame frame{.stamp = image.stamp,
              .levels = {{undistortion.camera, undistort_colour(undistortion, gray)}},
              .depth = Depth(undistortion, image.depth),
              .bgr = image.bgr};
  for (int l = 1; l < level_count; ++l) {
    const Level& finer = frame.levels.back();
    Level level{.camera = half_size(finer.camera), .gray = {}};
    cv::pyrDown(finer.gray, level.gray);
    frame.levels.push_back(level);
  }
  frame.sharpness =
      mean_squared_gradient(frame.levels[std::min<std::size_t>(1, frame.levels.size() - 1)].gray);
  return frame;
}

}  // namespace edvo
