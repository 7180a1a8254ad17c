// SPDX-License-Identifier: MIT
#include "edvo/odometry/config.hpp"

namespace edvo {

Config preset(Method method) {
  Config config;
  switch (method) {
    case Method::kCnnCorner:
      config.edge.detector = Detector::kNetwork;
      break;
    case Method::kCannyCorner:
      break;
    case Method::kCnn:
      config.edge.detector = Detector::kNetwork;
      config.corners.enabled = false;
      break;
    case Method::kCanny:
      config.corners.enabled = false;
      break;
    case Method::kOrigin:
      config.edge.detector = Detector::kNone;
      config.corners.enabled = false;
      config.selection.max_points = 10'000'000;
      // Frame to frame, as the paper's "without keyframes", and photometric only.
      config.keyframes = {.period = 1};
      config.motion.acceleration = 0;
      config.tracking.depth_weight = 0;
      config.tracking.rolling_shutter = false;
      config.tracking.loss = Loss::kHuber;  // Eq. 6
      config.tracking.loss_parameter = 1.345;
      config.window.keyframes = 0;
      break;
  }
  return config;
}

}  // namespace edvo
