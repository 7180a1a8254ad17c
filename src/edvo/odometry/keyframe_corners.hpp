// SPDX-License-Identifier: MIT
// Where the corners of the reference keyframe are found again in a frame: a guess of its motion
// that needs no earlier one, for views that alignment does not bring together from the motions
// expected.
#pragma once

#include "edvo/features/corner_features.hpp"

#include <optional>
#include <vector>

namespace edvo {

class KeyframeCorners {
 public:
  KeyframeCorners() = default;
  explicit KeyframeCorners(const Frame& keyframe) : frame_(keyframe) {}

  // cur_from_ref; none if too few corners agree on one.
  [[nodiscard]] std::optional<SE3> motion_to(const Frame& frame);

 private:
  Frame frame_;                          // shares its images
  std::vector<CornerFeature> features_;  // made when first needed
};

}  // namespace edvo
