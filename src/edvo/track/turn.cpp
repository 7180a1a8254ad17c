// SPDX-License-Identifier: MIT
#include "edvo/track/turn.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edvo {

SE3 turn_between(const cv::Mat_<std::uint8_t>& ref, const cv::Mat_<std::uint8_t>& cur,
                 const Camera& camera) {
  cv::Mat before, now, window;
  ref.convertTo(before, CV_32F);
  cur.convertTo(now, CV_32F);
  cv::createHanningWindow(window, ref.size(), CV_32F);  // else the borders correlate best
  const cv::Point2d shift = cv::phaseCorrelate(before, now, window);
  if (!std::isfinite(shift.x) || !std::isfinite(shift.y)) return {};
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();  // is seen there now
  const Eigen::Vector3d there(shift.x / camera.fx, shift.y / camera.fy, 1);
  return {.rotation = Eigen::Quaterniond::FromTwoVectors(ahead, there), .translation = {0, 0, 0}};
}

}  // namespace edvo
