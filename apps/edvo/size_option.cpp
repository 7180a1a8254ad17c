// SPDX-License-Identifier: MIT
#include "size_option.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>

#include <charconv>

namespace edvo::app {

cv::Size parse_size(const std::string& option, const std::string& text) {
  constexpr int kSmallest = 16, kLargest = 8192;  // [px]
  const auto is_side = [](int side) { return side >= kSmallest && side <= kLargest; };
  cv::Size size;
  const char* end = text.data() + text.size();
  const auto [cross, bad_width] = std::from_chars(text.data(), end, size.width);
  const bool has_cross = bad_width == std::errc{} && cross != end && *cross == 'x';
  const auto [last, bad_height] = std::from_chars(has_cross ? cross + 1 : end, end, size.height);
  if (!has_cross || bad_height != std::errc{} || last != end || !is_side(size.width) ||
      !is_side(size.height))
    throw Error(ErrorCode::kUsage,
                fmt::format("{} {}: expected WIDTHxHEIGHT, as 320x240, {} to {} pixels each",
                            option, text, kSmallest, kLargest));
  return size;
}

}  // namespace edvo::app
