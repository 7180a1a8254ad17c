// SPDX-License-Identifier: MIT
// Where the pixels of a camera look, and what solids their rays meet.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/synth/scene.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace edvo::synth {

// (x, y) of the ray (x, y, 1) through each pixel centre of a camera, lens distortion undone. One
// column and one row more than the image, so that every pixel has a right and a lower neighbour.
[[nodiscard]] cv::Mat_<cv::Vec2f> make_rays(const DistortedCamera& camera);

// A solid as one camera pose sees it. Vectors are in the solid's frame unless said otherwise. [m]
struct SolidInView {
  Shape shape = Shape::kBox;
  Eigen::Vector3f half = Eigen::Vector3f::Zero();
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();        // the camera's centre
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();  // its columns: the camera's axes
  Eigen::AlignedBox2f bounds;  // of its rays (x, y); empty if it lies behind the camera
  float nearest = 0;           // no point of it has a smaller depth [m]

  [[nodiscard]] Eigen::Vector3f direction(float ray_x, float ray_y) const {
    return rotation.col(0) * ray_x + rotation.col(1) * ray_y + rotation.col(2);
  }
};

[[nodiscard]] std::vector<SolidInView> view_from(const Scene& scene, double seconds,
                                                 const SE3& world_from_camera);

inline constexpr int kRoundFace = 6;  // the only face of a ball, the side of a cylinder

// All solids that a camera may see, the nearest first.
[[nodiscard]] std::vector<int> nearest_first(std::span<const SolidInView> solids);

// What a ray (x, y, 1) meets first.
struct Hit {
  float depth = 0;  // along the camera's z [m]; +infinity = nothing
  int solid = -1;
  int face = 0;  // [0..5] for -x +x -y +y -z +z, or kRoundFace
};

// Rays go in packs, which compilers turn into vector instructions.
inline constexpr int kPack = 8;

struct RayPack {
  std::array<float, kPack> x = {}, y = {};
};

// candidates: indices into solids, ordered by SolidInView::nearest.
[[nodiscard]] std::array<Hit, kPack> cast(std::span<const SolidInView> solids,
                                          std::span<const int> candidates, const RayPack& rays);

}  // namespace edvo::synth
