// SPDX-License-Identifier: MIT
// How a camera has turned, from how its image has shifted.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/hal.hpp>

namespace edvo {

// Shifts from one small image to others, by phase correlation (Kuglin, Hines 1975), as
// cv::phaseCorrelate finds them. Keeps the spectrum of the first, the window and the plans of the
// transforms, and takes nothing from the heap after the first image.
class PhaseCorrelation {
 public:
  // The image that shifts are measured from. Costs nothing right after shift_to(image).
  void set_reference(const cv::Mat_<std::uint8_t>& image);

  // Where what was at (0, 0) of the reference is now [px], at most half of the image; (0, 0)
  // without a reference, for an image of another size, or where there is nothing to correlate.
  cv::Point2d shift_to(const cv::Mat_<std::uint8_t>& image);

 private:
  void start(cv::Size size);
  void transform(const cv::Mat_<std::uint8_t>& image);  // to spectrum_

  cv::Size size_;                       // of the images
  cv::Mat_<std::uint8_t> transformed_;  // whose spectrum is in spectrum_
  cv::Mat_<float> window_;              // of their size: else their borders correlate best
  // Of a size that transforms quickly, in the packed format of OpenCV's real transforms.
  cv::Mat_<float> padded_, spectrum_, last_, product_, magnitudes_, whitened_;
  cv::Mat_<float> correlation_;
  cv::Ptr<cv::hal::DFT2D> forward_, inverse_;
};

// The turn about the image's axes, cur_from_ref, that explains a shift [px] of its middle. Roll and
// translation are left out.
[[nodiscard]] SE3 rotation_from_image_shift(const cv::Point2d& shift, const Camera& camera);

}  // namespace edvo
