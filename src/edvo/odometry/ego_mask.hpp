// SPDX-License-Identifier: MIT
// What moves along with the camera: something that a robot or a hand holds before it, dirt on its
// lens. Least squares would hold the pose by it. It is found without any pose: it rests in the
// image while the rest changes.
#pragma once

#include "edvo/align/motion_support.hpp"
#include "edvo/image/frame.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace edvo {

class EgoMask {
 public:
  // Compares a frame with those before it. True if cells were found or released.
  bool observe(const Frame& frame);

  // With their neighbours, in which the outline may lie.
  [[nodiscard]] const CellMask& cells() const { return cells_; }

 private:
  void begin(const cv::Mat_<std::uint8_t>& image, const Depth& depth);
  // Median of the cells that show something else than in the last image [m]; none if they are few.
  [[nodiscard]] std::optional<float> depth_of_change(const cv::Mat_<std::uint8_t>& image,
                                                     const Depth& depth) const;

  // The small image that the last change was seen in, and of each cell the one that it was last
  // seen to move in, with its depth there [m], 0 = none.
  cv::Mat_<std::uint8_t> last_, since_;
  std::array<float, kCells> depth_{};
  std::array<int, kCells> votes_{};  // frames that each cell has rested in since
  CellMask own_{}, cells_{};
  int pause_ = 0;  // frames to pass over
};

}  // namespace edvo
