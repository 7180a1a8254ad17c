// SPDX-License-Identifier: MIT
// The one interface of all edge detectors.
#pragma once

#include <opencv2/core.hpp>

namespace edvo {

class EdgeDetector {
 public:
  virtual ~EdgeDetector() = default;

  // bgr: H x W, 8-bit. Returns the edge strength, H x W, [0..1]. Thread-safe, same bits each time.
  [[nodiscard]] virtual cv::Mat_<float> detect(const cv::Mat_<cv::Vec3b>& bgr) const = 0;
};

}  // namespace edvo
