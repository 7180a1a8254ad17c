// SPDX-License-Identifier: MIT
// A keyframe as the tracker sees it: points in space with intensity and Jacobian, level by level.
#pragma once

#include "edvo/align/surface.hpp"
#include "edvo/features/pixel_selection.hpp"

#include <Eigen/Core>
#include <array>
#include <vector>

namespace edvo {

// Structure of arrays: the inner loops run over points. All arrays have the same length, padded by
// points of zeros so that eight can be read at a time (simd/float8.hpp).
struct ReferenceLevel {
  Camera camera;
  std::size_t count = 0;                       // of points
  std::vector<float> x, y, z;                  // in the keyframe camera [m]
  std::vector<float> intensity;                // [grey levels]
  std::vector<float> weight;                   // 1 / (1 + (gradient / gradient_weight_scale)^2)
  std::array<std::vector<float>, 6> jacobian;  // d intensity / d xi, xi = (rho, phi)
};

struct Reference {
  std::vector<ReferenceLevel> levels;  // as in the frame: 0 = full size
  SurfacePoints surface;
  Vector6d velocity = Vector6d::Zero();  // RollingShutter::velocity
};

struct ReferenceOptions {
  double gradient_weight_scale =
      40;  // [grey levels / px] gradient at which a pixel's weight is halved
  int finest_level = 0, coarsest_level = kMostLevels - 1;  // only these are filled
};

// Builds what the inverse-compositional alignment needs: at each level the points' intensities and
// the derivative of intensity by a motion of the point, both from the keyframe's own bilinear
// image. recycled: a reference of no more use, whose memory serves the new one.
[[nodiscard]] Reference make_reference(const Frame& frame, const std::vector<SelectedPixel>& pixels,
                                       const ReferenceOptions& options, Reference recycled = {});

}  // namespace edvo
