// SPDX-License-Identifier: MIT
// Flat pieces of a keyframe's surface, for point-to-plane alignment of depth.
#pragma once

#include "edvo/image/depth.hpp"

#include <opencv2/core.hpp>
#include <vector>

namespace edvo {

// Structure of arrays; the plane through point i is normal_i . x = 1, so that the residual
// normal_i . x - 1 is an error of depth as a share of depth. Padded by points of zeros so that
// eight can be read at a time (simd/float8.hpp).
struct SurfacePoints {
  std::vector<float> x, y, z;     // in the keyframe camera [m]
  std::vector<float> nx, ny, nz;  // [1 / m]

  void clear();
};

// One point per cell of the image, where 3 x 3 samples of the cell lie on a plane.
// noise: sigma of inverse depth [1 / m]. recycled: of no more use,
// its memory serves the new one.
[[nodiscard]] SurfacePoints make_surface(const Depth& depth, const Camera& camera, int cell,
                                         double noise, SurfacePoints recycled = {});

}  // namespace edvo
