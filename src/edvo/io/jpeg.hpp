// SPDX-License-Identifier: MIT
// Compresses pictures for people to look at.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace edvo {

// A JPEG file's bytes. image: CV_8UC3 (BGR) or CV_8UC1, not empty; quality: [1..100]. Throws
// Error(kInternal) for any other image, and where the encoder fails.
[[nodiscard]] std::string encode_jpeg(const cv::Mat& image, int quality);

}  // namespace edvo
