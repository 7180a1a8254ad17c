// SPDX-License-Identifier: MIT
// What the benchmarks of single stages run on: rendered, so that no data is needed.
#pragma once

#include "edvo/align/align.hpp"
#include "edvo/features/corners.hpp"
#include "edvo/synth/sequence.hpp"

namespace edvo::benchmarks {

constexpr int kSecondFrame = 3;  // a tenth of a second after the keyframe

// Two frames of the demo's room, and what the stages before each benchmark make of them.
struct World {
  Config config = preset(Method::kCannyCorner);
  synth::SyntheticSequence sequence = synth::make_sequence({});
  RgbdImage first_image = synth::make_frame(sequence, 0);
  RgbdImage second_image = synth::make_frame(sequence, kSecondFrame);
  Undistortion undistortion = make_undistortion(sequence.camera);
  Frame first = make_frame(first_image, undistortion);
  Frame second = make_frame(second_image, undistortion);
  cv::Mat_<std::uint8_t> edges = canny_edges(first.levels.front().gray, config.canny);
  cv::Mat_<std::uint8_t> mask = mask_of(first);
  std::vector<SelectedPixel> pixels =
      select_pixels(first, mask, undistortion.valid, config.selection);
  Reference reference = reference_with_surface();

  [[nodiscard]] cv::Mat_<std::uint8_t> mask_of(const Frame& frame) const {
    return with_corner_discs(canny_edges(frame.levels.front().gray, config.canny), config.corners);
  }

  [[nodiscard]] Reference reference_with_surface() const {
    Reference made = make_reference(
        first, pixels, {.gradient_weight_scale = config.tracking.gradient_weight_scale});
    made.surface = make_surface(first.depth, undistortion.camera, config.tracking.surface_cell,
                                config.tracking.depth_noise);
    return made;
  }
};

}  // namespace edvo::benchmarks
