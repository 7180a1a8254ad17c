// SPDX-License-Identifier: MIT
// Image sizes on the command line.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace edvo::app {

// "320x240" [px]. Throws Error(kUsage) that names the option.
[[nodiscard]] cv::Size parse_size(const std::string& option, const std::string& text);

}  // namespace edvo::app
