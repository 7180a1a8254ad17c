// SPDX-License-Identifier: MIT
// How a camera has turned, from how its image has shifted.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/core/se3.hpp"

#include <cstdint>
#include <opencv2/core.hpp>

namespace edvo {

// The turn about the image's axes, cur_from_ref, that explains the shift between two small images
// of the same size: as far as half of it, where gradients no longer tell. By phase correlation
// (Kuglin, Hines 1975); none if there is nothing to correlate. Roll and translation are left out.
[[nodiscard]] SE3 turn_between(const cv::Mat_<std::uint8_t>& ref, const cv::Mat_<std::uint8_t>& cur,
                               const Camera& camera);

}  // namespace edvo
