// SPDX-License-Identifier: MIT
// The network of fixed weights in tests/data, and what may be wrong with it.
#pragma once

#include "edvo/io/model_file.hpp"

#include <string>
#include <string_view>

namespace edvo::test {

inline const std::filesystem::path kTinyModel = EDVO_SOURCE_DIR "/tests/data/tiny_edges.toml";

[[nodiscard]] inline Model tiny_model() {
  return read_model(kTinyModel);
}

// The bytes with the first occurrence of one piece replaced by another of the same length.
[[nodiscard]] inline std::string patched(std::string bytes, std::string_view from,
                                         std::string_view to) {
  const std::size_t place = bytes.find(from);
  if (place == std::string::npos || from.size() != to.size())
    throw std::logic_error("nothing to patch");
  return bytes.replace(place, from.size(), to);
}

// An image with a bright square of [20..59] x [10..39] on a dark ground.
[[nodiscard]] inline cv::Mat_<cv::Vec3b> bright_square(cv::Size size = {96, 64}) {
  cv::Mat_<cv::Vec3b> image(size, cv::Vec3b(40, 50, 60));
  image(cv::Rect(20, 10, 40, 30)).setTo(cv::Scalar(200, 210, 220));
  return image;
}

}  // namespace edvo::test
