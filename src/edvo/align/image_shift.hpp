// SPDX-License-Identifier: MIT
// How a camera has turned, from how its image has shifted.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/hal.hpp>

namespace edvo {

// Shifts from each of a row of small images to the next, by phase correlation (Kuglin, Hines 1975),
// as cv::phaseCorrelate finds them. Keeps the last image's spectrum, the window and the plans of
// the transforms, and takes nothing from the heap after the first image.
class PhaseCorrelation {
 public:
  // Where what was at (0, 0) is now [px], at most half of the image; none after the first image,
  // one of another size, or where there is nothing to correlate.
  cv::Point2d shift_to(const cv::Mat_<std::uint8_t>& image);

 private:
  void start(cv::Size size);

  cv::Size size_;           // of the images
  cv::Mat_<float> window_;  // of their size: else their borders correlate best
  // Of a size that transforms quickly, in the packed format of OpenCV's real transforms.
  cv::Mat_<float> padded_, spectrum_, last_, product_, magnitudes_, whitened_;
  cv::Mat_<float> correlation_;
  cv::Ptr<cv::hal::DFT2D> forward_, inverse_;
};

// The turn about the image's axes, cur_from_ref, that explains a shift [px] of its middle. Roll and
// translation are left out.
[[nodiscard]] SE3 rotation_from_image_shift(const cv::Point2d& shift, const Camera& camera);

}  // namespace edvo
