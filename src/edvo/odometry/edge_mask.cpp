// SPDX-License-Identifier: MIT
#include "edvo/odometry/edge_mask.hpp"

namespace edvo {

cv::Mat_<std::uint8_t> edge_mask(const Frame& frame, const Undistortion& undistortion,
                                 const EdgeDetector* network, const Config& config) {
  switch (config.edge.detector) {
    case Detector::kCanny:
      return canny_edges(frame.levels.front().gray, config.canny);
    case Detector::kNetwork:
      return network_edges(network->detect(undistort_colour(undistortion, frame.bgr)),
                           frame.levels.front().gray, config.network);
    case Detector::kNone:
      break;
  }
  return cv::Mat_<std::uint8_t>(frame.depth.size(), std::uint8_t{255});
}

}  // namespace edvo
