// SPDX-License-Identifier: MIT
// The colour of pixels whose surface is known.
#pragma once

#include "edvo/synth/rays.hpp"
#include "edvo/synth/scene.hpp"
#include "edvo/synth/shadow.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace edvo::synth {

// How a face of a solid is painted and lit. Coordinates are those of the solid.
struct FacePaint {
  int texture = 0;                                     // index into Scene::textures
  Eigen::Vector3f dark = Eigen::Vector3f::Zero();      // BGR [grey levels]
  Eigen::Vector3f bright = Eigen::Vector3f::Zero();    // more than dark, BGR [grey levels]
  int axis = 0, u = 0, v = 0;                          // of the normal and of the face's two sides
  float plane = 0;                                     // where the face cuts its axis [m]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    // to the side that is seen; round: zero
  Eigen::Array2f tiles = Eigen::Array2f::Zero();       // along u and v, negative: mirrored [1/m]
  Eigen::Array2f first_tile = Eigen::Array2f::Zero();  // at the solid's origin [tiles]
  float texels = 0;                                    // [1/m]
};

// A scene as one camera sees it.
struct View {
  const Scene& scene;
  const cv::Mat_<cv::Vec2f>& rays;  // of make_rays
  std::vector<SolidInView> solids;
  std::vector<int> order;                        // of solids that may be seen, nearest first
  std::vector<std::array<FacePaint, 7>> paints;  // of the faces of each solid
  std::vector<Eigen::Vector3f> lights;           // the lamp in the frame of each solid [m]
  std::vector<Caster> casters;                   // empty: no shadows
  std::vector<Eigen::Isometry3f> world_from_solids;
  Eigen::Vector3f lamp = Eigen::Vector3f::Zero();  // in the world [m]
  float pixel_angle = 0;                           // [rad]
};

[[nodiscard]] View make_warp(const Scene& scene, double seconds, const SE3& world_from_camera,
                             const cv::Mat_<cv::Vec2f>& rays);

struct Shade {
  cv::Vec3f bgr;        // averaged over the pixel's footprint [grey levels]
  float incidence = 0;  // cosine of ray and surface normal at the pixel's centre [0..1]
};

// A pixel whose footprint lies in one flat face: only the texture is sampled more than once.
[[nodiscard]] Shade shade_flat(const View& view, const Hit& hit, int x, int y);

// Any pixel; its footprint is covered by rays of their own, which meet the candidates.
[[nodiscard]] Shade shade_edge(const View& view, std::span<const int> candidates, const Hit& hit,
                               int x, int y);

}  // namespace edvo::synth
