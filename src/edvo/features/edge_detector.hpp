// SPDX-License-Identifier: MIT
// Where the edges of a keyframe come from: the one interface of Canny, networks and your own.
#pragma once

#include "edvo/features/canny.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>

namespace edvo {

// One undistorted image.
struct EdgeInput {
  const cv::Mat_<std::uint8_t>& gray;           // H x W [grey levels]
  std::function<cv::Mat_<cv::Vec3b>()> colour;  // H x W, BGR; made when asked for
};

class EdgeDetector {
 public:
  virtual ~EdgeDetector() = default;

  // Returns H x W, 255 = edge, 0 = none. Called by one thread at a time; must give the same bits
  // for the same image.
  [[nodiscard]] virtual cv::Mat_<std::uint8_t> detect(const EdgeInput& image) const = 0;
};

[[nodiscard]] std::unique_ptr<EdgeDetector> make_canny_detector(const CannyOptions& options);

// Every pixel is an edge: for the dense method.
[[nodiscard]] std::unique_ptr<EdgeDetector> make_dense_detector();

}  // namespace edvo
