// SPDX-License-Identifier: MIT
// Alignment by geometry of edges: how far the keyframe's edge points land from the nearest edge of
// the current image. Independent of brightness.
#pragma once

#include "edvo/align/pose_sums.hpp"
#include "edvo/core/se3.hpp"
#include "edvo/features/pixel_selection.hpp"

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace edvo {

// Distance to the nearest edge, one image per pyramid level, truncated [px of the level].
using EdgeDistance = std::vector<cv::Mat_<float>>;

// [px of the level] An edge farther off is not the same edge.
constexpr float kFarthestEdge = 10.F;

// edges: H x W of level 0, 255 = edge. Level l holds every 2^l-th pixel of every 2^l-th row: those
// that the pyramid's cameras keep in place.
[[nodiscard]] EdgeDistance make_edge_distance(const cv::Mat_<std::uint8_t>& edges, int levels);

// Those of the pixels that lie on an edge of the keyframe's own distance image, in space [m].
[[nodiscard]] std::vector<Eigen::Vector3f> edge_points(const EdgeDistance& distance,
                                                       const Camera& camera,
                                                       const std::vector<SelectedPixel>& pixels);

// Residuals distance(pi(cur_from_ref p)) / sigma with Huber's loss. Points out of view pay the loss
// of the farthest edge. distance and camera: of one level. sigma: [px of the level].
[[nodiscard]] PoseSums sum_edge_distance(const std::vector<Eigen::Vector3f>& points,
                                         const Camera& camera, const cv::Mat_<float>& distance,
                                         const SE3& cur_from_ref, float sigma, float weight);

}  // namespace edvo
