// SPDX-License-Identifier: MIT
// Where the pixels of a camera look, and what solids their rays meet.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/synth/scene.hpp"

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace edvo::synth {

// (x, y) of the ray (x, y, 1) through each pixel centre of a camera, lens distortion undone. One
// column and one row more than the image, so that every pixel has a right and a lower neighbour.
[[nodiscard]] cv::Mat_<cv::Vec2f> make_rays(const DistortedCamera& camera);

// A solid as one camera pose sees it. Lengths in [m]; the fourth lane is idle.
struct SolidInView {
  Shape shape = Shape::kBox;
  Eigen::Array4f origin, x, y, z;  // camera centre and camera axes in the solid's frame
  Eigen::Array4f half;
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  // in the camera's frame
  float radius = 0;                                  // of the sphere around it

  [[nodiscard]] Eigen::Array4f direction(float ray_x, float ray_y) const {
    return x * ray_x + y * ray_y + z;
  }
};

[[nodiscard]] std::vector<SolidInView> view_from(const Scene& scene, double seconds,
                                                 const SE3& world_from_camera);

inline constexpr int kRoundFace = 6;  // the only face of a ball, the side of a cylinder

// What a ray (x, y, 1) meets first.
struct Hit {
  float depth = 0;  // along the camera's z [m]; +infinity = nothing
  int solid = -1;
  int face = 0;  // [0..5] for -x +x -y +y -z +z, or kRoundFace
};

[[nodiscard]] Hit cast(std::span<const SolidInView> solids, std::span<const int> candidates,
                       float ray_x, float ray_y);

}  // namespace edvo::synth
