// SPDX-License-Identifier: MIT
// A sequence that can be tracked: a camera slides along a textured wall.
#pragma once

#include "edvo/io/image_file.hpp"
#include "support/temporary_folder.hpp"

#include <fmt/core.h>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace edvo::test {

struct SlidingSequence {
  int frames = 12;
  cv::Size size = {160, 120};      // [px]
  double focal_length = 130;       // [px]
  double distance = 2;             // of the wall [m]
  int pixels_per_frame = 2;        // how far the image slides [px]
  double ground_truth_offset = 0;  // added to the stamps of the ground truth [s]
};

[[nodiscard]] inline std::string sliding_stamp(int frame) {
  return fmt::format("{}.{:02}0000", 100 + frame / 20, 5 * (frame % 20));
}

// Writes a TUM-layout folder with ground truth and calibration.txt.
inline void write_sliding_sequence(const std::filesystem::path& folder,
                                   const SlidingSequence& sequence = {}) {
  namespace fs = std::filesystem;
  fs::create_directories(folder / "rgb");
  fs::create_directories(folder / "depth");
  const int slide = sequence.pixels_per_frame * sequence.frames;
  cv::Mat wall(sequence.size.height, sequence.size.width + slide, CV_8UC3);
  cv::RNG random(7);
  random.fill(wall, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(wall, wall, {}, 2.0);
  cv::normalize(wall, wall, 0, 255, cv::NORM_MINMAX);
  constexpr double kUnitsPerMetre = 5000;
  cv::Mat depth(sequence.size, CV_16UC1, cv::Scalar::all(kUnitsPerMetre * sequence.distance));
  for (int row = 0; row < depth.rows; row += 2)
    depth.row(row) += 1;  // a single value all over would be no depth
  std::ofstream rgb_list(folder / "rgb.txt"), depth_list(folder / "depth.txt");
  std::ofstream truth(folder / "groundtruth.txt");
  for (int i = 0; i < sequence.frames; ++i) {
    const std::string stamp = sliding_stamp(i);
    const cv::Rect view({i * sequence.pixels_per_frame, 0}, sequence.size);
    write_png(folder / "rgb" / (stamp + ".png"), wall(view).clone());
    write_png(folder / "depth" / (stamp + ".png"), depth);
    rgb_list << stamp << " rgb/" << stamp << ".png\n";
    depth_list << stamp << " depth/" << stamp << ".png\n";
    truth << fmt::format("{:.6f} {:.9f} 0 0 0 0 0 1\n",
                         std::stod(stamp) + sequence.ground_truth_offset,
                         i * sequence.pixels_per_frame * sequence.distance / sequence.focal_length);
  }
  std::ofstream(folder / "calibration.txt")
      << fmt::format("{0} {0} {1} {2}\n", sequence.focal_length, 0.5 * (sequence.size.width - 1),
                     0.5 * (sequence.size.height - 1));
}

}  // namespace edvo::test
