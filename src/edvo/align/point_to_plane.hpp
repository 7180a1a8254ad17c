// SPDX-License-Identifier: MIT
// Alignment of a frame's depth to the flat pieces of a keyframe's surface (Chen, Medioni 1992).
#pragma once

#include "edvo/align/point_range.hpp"
#include "edvo/align/pose_sums.hpp"
#include "edvo/align/surface.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/image/depth.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace edvo {

// What a frame's sensor saw where each point of a surface projects to.
struct DepthAssociations {
  std::vector<float> x, y, z;        // in the frame's camera [m], NaN where nothing was measured
  std::vector<std::int32_t> pixels;  // room to work in
  std::optional<SE3> from;           // cur_from_ref by which it was looked up

  // Whether points have moved so far in the image since that others are seen where they are now.
  [[nodiscard]] bool is_stale(const SE3& cur_from_ref, const Camera& camera) const;
};

// camera: of the depth.
void associate_depth(const SurfacePoints& surface, const Camera& camera, const Depth& depth,
                     const SE3& cur_from_ref, DepthAssociations& associations);

// Residuals n . (ref_from_cur x_cur) - 1, x_cur the point that was seen: a share of depth, so its
// sigma is that of inverse depth times depth. noise: sigma of inverse depth [1 / m].
[[nodiscard]] PoseSums sum_surface(const SurfacePoints& surface,
                                   const DepthAssociations& associations, PointRange range,
                                   const SE3& cur_from_ref, float noise, float weight);

// Sigma of those residuals as one of inverse depth [1 / m], from their median; 0 without any.
// errors: room to work in.
[[nodiscard]] float surface_sigma(const SurfacePoints& surface,
                                  const DepthAssociations& associations, const SE3& cur_from_ref,
                                  std::vector<float>& errors);

}  // namespace edvo
