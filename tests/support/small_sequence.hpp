// SPDX-License-Identifier: MIT
// Sequences of tiny images, for readers.
#pragma once

#include "edvo/io/image_file.hpp"
#include "support/temporary_folder.hpp"

#include <fmt/core.h>
#include <filesystem>
#include <string>
#include <string_view>

namespace edvo::test {

inline constexpr int kSmallWidth = 10, kSmallHeight = 8;  // [px]

// All pixels alike: enough to tell frames apart.
inline void write_colour(const std::filesystem::path& file, int value,
                         cv::Size size = {kSmallWidth, kSmallHeight}) {
  std::filesystem::create_directories(file.parent_path());
  write_png(file, cv::Mat(size, CV_8UC3, cv::Scalar::all(value)));
}

inline void write_depth(const std::filesystem::path& file, int value,
                        cv::Size size = {kSmallWidth, kSmallHeight}) {
  std::filesystem::create_directories(file.parent_path());
  write_png(file, cv::Mat(size, CV_16UC1, cv::Scalar::all(value)));
}

// A TUM-layout folder of count frames, 0.1 s apart from 10.0 s on, depth 5 ms after colour;
// frame i has colour i and depth 5000 + i.
inline void write_tum_sequence(const std::filesystem::path& folder, int count) {
  std::filesystem::create_directories(folder);
  std::ofstream rgb(folder / "rgb.txt"), depth(folder / "depth.txt");
  for (int i = 0; i < count; ++i) {
    const std::string colour_stamp = fmt::format("10.{}00", i);
    const std::string depth_stamp = fmt::format("10.{}05", i);
    rgb << colour_stamp << " rgb/" << colour_stamp << ".png\n";
    depth << depth_stamp << " depth/" << depth_stamp << ".png\n";
    write_colour(folder / "rgb" / (colour_stamp + ".png"), i);
    write_depth(folder / "depth" / (depth_stamp + ".png"), 5000 + i);
  }
}

}  // namespace edvo::test
